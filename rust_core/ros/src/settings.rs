//! The settings that a dynamic_reconfigure server offers, as one table: name, documentation, value, default and range.
//!
//! The messages of dynamic_reconfigure are views of it. As in any server, a value out of range becomes the nearest one
//! within, and one that is unknown or of another type is ignored.

use crate::xmlrpc::Value;
use rcs_messages::dynamic_reconfigure::{
    BoolParameter, Config, ConfigDescription, DoubleParameter, Group, GroupState, IntParameter, ParamDescription,
    StrParameter,
};
use std::mem::discriminant;

/// A setting: `value`, `default` and `range` are all booleans, integers, doubles or strings.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Name, valid in ROS and Python.
    pub name: String,
    /// Name for the operator's page, and the value's unit; empty for what only dynamic_reconfigure shows.
    pub label: (&'static str, &'static str),
    /// Description for the user.
    pub description: String,
    /// Value that applies.
    pub value: Value,
    /// Default value.
    pub default: Value,
    /// Least and greatest value; empty strings for strings.
    pub range: [Value; 2],
    /// The strings to choose from; empty without a choice.
    pub choices: Vec<&'static str>,
}

/// Settings that clients show together, below a name; that of the first group is not shown.
pub type SettingGroup = (&'static str, Vec<Setting>);

/// Values by name, as a client sends them.
pub type NamedValues = Vec<(String, Value)>;

impl Setting {
    /// A setting with its value and its default, and its least and greatest value.
    pub fn new<T: Into<Value>>(name: &str, description: &str, values: [T; 2], range: [T; 2]) -> Self {
        let (name, description, [value, default]) = (name.to_owned(), description.to_owned(), values.map(T::into));
        Self { name, label: ("", ""), description, value, default, range: range.map(T::into), choices: Vec::new() }
    }

    /// The setting with a name for the operator's page and the unit of its value.
    #[must_use]
    pub fn labelled(self, label: &'static str, unit: &'static str) -> Self {
        Self { label: (label, unit), ..self }
    }

    /// A switch, with its value and its default.
    pub fn switch(name: &str, description: &str, values: [bool; 2]) -> Self {
        Self::new(name, description, values, [false, true])
    }

    /// One of some strings, with its value and its default.
    pub fn choice(name: &str, description: &str, values: [&str; 2], choices: Vec<&'static str>) -> Self {
        Self { choices, ..Self::new(name, description, values, ["", ""]) }
    }

    /// The type's name: `bool`, `int`, `double` or `str`.
    pub fn kind(&self) -> &'static str {
        match self.value {
            Value::Bool(_) => "bool",
            Value::Int(_) => "int",
            Value::Double(_) => "double",
            _ => "str",
        }
    }

    /// A value within the range; `None` for NaN and for one of another type.
    pub fn accept(&self, value: Value) -> Option<Value> {
        let is_same_type = discriminant(&value) == discriminant(&self.value);
        match (value, &self.range) {
            (Value::Int(value), [Value::Int(least), Value::Int(most)]) => {
                Some(Value::Int(value.min(*most).max(*least)))
            }
            (Value::Double(value), [Value::Double(least), Value::Double(most)]) => {
                (!value.is_nan()).then(|| Value::Double(value.min(*most).max(*least)))
            }
            (value, _) => is_same_type.then_some(value),
        }
    }

    fn described(&self) -> ParamDescription {
        let choice = |name: &&str| {
            format!(
                "{{'name': '{name}', 'type': 'str', 'value': '{name}', 'srcline': 0, 'srcfile': '', 'description': '', \
                 'ctype': 'std::string', 'cconsttype': 'const char * const'}}"
            )
        };
        // A Python expression, which the clients evaluate.
        let edit_method = match self.choices.iter().map(choice).collect::<Vec<_>>().join(", ") {
            none if none.is_empty() => none,
            choices => format!("{{'enum_description': '{}', 'enum': [{choices}]}}", self.description),
        };
        let (name, description) = (self.name.clone(), self.description.clone());
        ParamDescription { name, r#type: self.kind().to_owned(), level: 0, description, edit_method }
    }
}

/// All settings of some groups.
pub fn settings(groups: &[SettingGroup]) -> impl Iterator<Item = &Setting> {
    groups.iter().flat_map(|(_, settings)| settings)
}

/// The values that known settings accept of a request.
pub fn accepted(groups: &[SettingGroup], request: &[(String, Value)]) -> NamedValues {
    let accept = |(name, value): &(String, Value)| {
        let setting = settings(groups).find(|setting| setting.name == *name)?;
        Some((name.clone(), setting.accept(value.clone())?))
    };
    request.iter().filter_map(accept).collect()
}

/// The values of a message.
pub(crate) fn named_values(config: Config) -> NamedValues {
    let bools = config.bools.into_iter().map(|param| (param.name, Value::Bool(param.value)));
    let ints = config.ints.into_iter().map(|param| (param.name, Value::Int(param.value)));
    let strs = config.strs.into_iter().map(|param| (param.name, Value::String(param.value)));
    let doubles = config.doubles.into_iter().map(|param| (param.name, Value::Double(param.value)));
    bools.chain(ints).chain(strs).chain(doubles).collect()
}

/// The message with one value of each setting.
pub(crate) fn config(groups: &[SettingGroup], value_of: impl Fn(&Setting) -> &Value) -> Config {
    let state =
        |(id, (name, _)): (i32, &SettingGroup)| GroupState { name: (*name).to_owned(), state: true, id, parent: 0 };
    let mut config = Config { groups: (0..).zip(groups).map(state).collect(), ..Config::default() };
    for setting in settings(groups) {
        let name = setting.name.clone();
        match value_of(setting) {
            Value::Bool(value) => config.bools.push(BoolParameter { name, value: *value }),
            Value::Int(value) => config.ints.push(IntParameter { name, value: *value }),
            Value::Double(value) => config.doubles.push(DoubleParameter { name, value: *value }),
            Value::String(value) => config.strs.push(StrParameter { name, value: value.clone() }),
            Value::Array(_) | Value::Struct(_) | Value::Other(..) => {}
        }
    }
    config
}

/// The message that describes the settings.
pub(crate) fn description(groups: &[SettingGroup]) -> ConfigDescription {
    let group = |(id, (name, settings)): (i32, &SettingGroup)| {
        let parameters = settings.iter().map(Setting::described).collect();
        Group { name: (*name).to_owned(), parameters, id, ..Group::default() }
    };
    ConfigDescription {
        groups: (0..).zip(groups).map(group).collect(),
        max: config(groups, |setting| &setting.range[1]),
        min: config(groups, |setting| &setting.range[0]),
        dflt: config(groups, |setting| &setting.default),
    }
}
