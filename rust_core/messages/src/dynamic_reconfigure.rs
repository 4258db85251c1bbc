//! Messages of `dynamic_reconfigure`, by which rqt_reconfigure and dynparam change a node's settings.

use crate::fields::{fields_in_order, message_types, service_types, with_parts};

fields_in_order! {
    /// `dynamic_reconfigure/BoolParameter`
    BoolParameter {
        /// Name of the parameter.
        name: String,
        /// Value.
        value: bool,
    }
    /// `dynamic_reconfigure/IntParameter`
    IntParameter {
        /// Name of the parameter.
        name: String,
        /// Value.
        value: i32,
    }
    /// `dynamic_reconfigure/StrParameter`
    StrParameter {
        /// Name of the parameter.
        name: String,
        /// Value.
        value: String,
    }
    /// `dynamic_reconfigure/DoubleParameter`
    DoubleParameter {
        /// Name of the parameter.
        name: String,
        /// Value.
        value: f64,
    }
    /// `dynamic_reconfigure/GroupState`
    GroupState {
        /// Name of the group.
        name: String,
        /// `true` if it is open.
        state: bool,
        /// Id; 0 is the group that contains all others.
        id: i32,
        /// Id of the group around it.
        parent: i32,
    }
    /// `dynamic_reconfigure/Config`: values of parameters.
    Config {
        /// Booleans.
        bools: Vec<BoolParameter>,
        /// Integers.
        ints: Vec<IntParameter>,
        /// Strings.
        strs: Vec<StrParameter>,
        /// Floating-point numbers.
        doubles: Vec<DoubleParameter>,
        /// Groups of the parameters.
        groups: Vec<GroupState>,
    }
    /// `dynamic_reconfigure/ParamDescription`
    ParamDescription {
        /// Name of the parameter.
        name: String,
        /// `bool`, `int`, `str` or `double`.
        r#type: String,
        /// Bits that tell the server's callback what changed.
        level: u32,
        /// Description for the user.
        description: String,
        /// Python expression that lists the choices, or empty.
        edit_method: String,
    }
    /// `dynamic_reconfigure/Group`
    Group {
        /// Name of the group.
        name: String,
        /// Appearance; empty for a frame around its parameters.
        r#type: String,
        /// Parameters of the group.
        parameters: Vec<ParamDescription>,
        /// Id of the group around it.
        parent: i32,
        /// Id.
        id: i32,
    }
    /// `dynamic_reconfigure/ConfigDescription`: parameters with their bounds and defaults.
    ConfigDescription {
        /// Groups, the outermost first.
        groups: Vec<Group>,
        /// Greatest values.
        max: Config,
        /// Least values.
        min: Config,
        /// Default values.
        dflt: Config,
    }
}

service_types! {
    // Request and response have one field each, which is such a message.
    /// `dynamic_reconfigure/Reconfigure`: sets parameters and returns all values that apply then.
    Reconfigure(Config) -> Config:
        "dynamic_reconfigure/Reconfigure", "bb125d226a21982a4a98760418dc2672", "Config config\n---\nConfig config\n";
}

const CONFIG_FIELDS: &str =
    "BoolParameter[] bools\nIntParameter[] ints\nStrParameter[] strs\nDoubleParameter[] doubles\nGroupState[] groups\n";

/// Definitions of the parts, by name.
const PARTS: [(&str, &str); 8] = [
    ("dynamic_reconfigure/Group", "string name\nstring type\nParamDescription[] parameters\nint32 parent\nint32 id\n"),
    (
        "dynamic_reconfigure/ParamDescription",
        "string name\nstring type\nuint32 level\nstring description\nstring edit_method\n",
    ),
    ("dynamic_reconfigure/Config", CONFIG_FIELDS),
    ("dynamic_reconfigure/BoolParameter", "string name\nbool value\n"),
    ("dynamic_reconfigure/IntParameter", "string name\nint32 value\n"),
    ("dynamic_reconfigure/StrParameter", "string name\nstring value\n"),
    ("dynamic_reconfigure/DoubleParameter", "string name\nfloat64 value\n"),
    ("dynamic_reconfigure/GroupState", "string name\nbool state\nint32 id\nint32 parent\n"),
];

message_types! {
    Config: "dynamic_reconfigure/Config", "958f16a05573709014982821e6822580", with_parts(CONFIG_FIELDS, &PARTS[3..]);
    ConfigDescription: "dynamic_reconfigure/ConfigDescription", "757ce9d44ba8ddd801bb30bc456f946f",
        with_parts("Group[] groups\nConfig max\nConfig min\nConfig dflt\n", &PARTS);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rosrust::RosMsg;
    use std::io::Read as _;

    fn config() -> Config {
        Config {
            bools: vec![BoolParameter { name: "b".to_owned(), value: true }],
            ints: vec![IntParameter { name: "i".to_owned(), value: -2 }],
            strs: vec![StrParameter { name: "s".to_owned(), value: "ü".to_owned() }],
            doubles: vec![DoubleParameter { name: "d".to_owned(), value: 0.5 }],
            groups: vec![GroupState { name: "Default".to_owned(), state: true, id: 0, parent: 0 }],
        }
    }

    #[test]
    fn a_message_comes_back_as_it_was() {
        let description = ConfigDescription {
            groups: vec![Group { name: "Default".to_owned(), ..Group::default() }],
            max: config(),
            ..ConfigDescription::default()
        };
        assert_eq!(crate::decode::<ConfigDescription>(&crate::encode(&description)).unwrap(), description);
    }

    #[test]
    fn a_request_that_announces_more_than_it_brings_is_an_error() {
        let bytes = crate::encode(&config());
        for len in 0..bytes.len() {
            assert!(Config::decode(&bytes[..len]).is_err(), "{len}");
        }
        // Four billion elements, and a string of four gigabytes in the first of them.
        assert!(Config::decode(&[0xff; 9][..]).is_err());
        // Elements that never end.
        assert!(Config::decode(std::io::repeat(1)).is_err());
        assert!(Config::decode(std::io::Cursor::new([0xff; 4]).chain(std::io::repeat(0))).is_err());
    }
}
