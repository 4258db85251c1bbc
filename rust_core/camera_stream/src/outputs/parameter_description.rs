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

/// The strings of [`choice_of`] in a parameter's description; empty without a choice.
pub(crate) fn choices(edit_method: &str) -> impl Iterator<Item = &str> {
    edit_method.split("'value': '").skip(1).filter_map(|rest| rest.split('\'').next())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_choices_of_a_description_are_found_again() {
        assert_eq!(choices(&choice_of("Kind", ["rgb8", "mono8"])).collect::<Vec<_>>(), ["rgb8", "mono8"]);
        assert_eq!(choices("").count(), 0);
    }
}
