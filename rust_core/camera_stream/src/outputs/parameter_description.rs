//! Descriptions of parameters as dynamic_reconfigure's clients read them.

use rcs_messages::dynamic_reconfigure::ParamDescription;

/// A parameter of a kind (`bool`, `int`, `double` or `str`); `edit_method` is empty, or what it can be chosen from.
pub(crate) fn parameter(name: &str, kind: &str, description: &str, edit_method: String) -> ParamDescription {
    ParamDescription {
        name: name.to_owned(),
        r#type: kind.to_owned(),
        level: 0,
        description: description.to_owned(),
        edit_method,
    }
}

/// Strings to choose from, as the Python expression that the clients evaluate.
pub(crate) fn choice_of<'a>(description: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let choice = |name: &str| {
        format!(
            "{{'name': '{name}', 'type': 'str', 'value': '{name}', 'srcline': 0, 'srcfile': '', 'description': '', \
             'ctype': 'std::string', 'cconsttype': 'const char * const'}}"
        )
    };
    let choices: Vec<String> = names.into_iter().map(choice).collect();
    format!("{{'enum_description': '{description}', 'enum': [{}]}}", choices.join(", "))
}
