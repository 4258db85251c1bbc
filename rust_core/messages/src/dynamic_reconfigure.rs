//! The messages of `dynamic_reconfigure`, by which rqt_reconfigure and dynparam change a running node's settings.
//!
//! They are types of our own, so that the programs can be built where that package is not installed.

use crate::fields::{fields_in_order, with_parts};
use rosrust::{Message, RosMsg, ServicePair};
use std::io;

fields_in_order! {
    /// `dynamic_reconfigure/BoolParameter`
    BoolParameter {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: bool,
    }
    /// `dynamic_reconfigure/IntParameter`
    IntParameter {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: i32,
    }
    /// `dynamic_reconfigure/StrParameter`
    StrParameter {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: String,
    }
    /// `dynamic_reconfigure/DoubleParameter`
    DoubleParameter {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: f64,
    }
    /// `dynamic_reconfigure/GroupState`
    GroupState {
        /// Name of the group.
        name: String,
        /// Whether it is open.
        state: bool,
        /// Its number; 0 is the group that holds all others.
        id: i32,
        /// The number of the group around it.
        parent: i32,
    }
    /// `dynamic_reconfigure/Config`: values of parameters.
    Config {
        /// The switches.
        bools: Vec<BoolParameter>,
        /// The whole numbers.
        ints: Vec<IntParameter>,
        /// The texts.
        strs: Vec<StrParameter>,
        /// The numbers.
        doubles: Vec<DoubleParameter>,
        /// The groups that the parameters are in.
        groups: Vec<GroupState>,
    }
    /// `dynamic_reconfigure/ParamDescription`
    ParamDescription {
        /// Name of the parameter.
        name: String,
        /// `bool`, `int`, `str` or `double`.
        r#type: String,
        /// Bits by which the server's callback sees what changed.
        level: u32,
        /// What it does, for the user.
        description: String,
        /// A Python expression that lists the choices, or empty.
        edit_method: String,
    }
    /// `dynamic_reconfigure/Group`
    Group {
        /// Name of the group.
        name: String,
        /// How it is shown; empty for a frame around its parameters.
        r#type: String,
        /// What is in it, besides other groups.
        parameters: Vec<ParamDescription>,
        /// The number of the group around it.
        parent: i32,
        /// Its number.
        id: i32,
    }
    /// `dynamic_reconfigure/ConfigDescription`: what parameters there are, with their bounds and defaults.
    ConfigDescription {
        /// All groups, the outermost first.
        groups: Vec<Group>,
        /// The largest values.
        max: Config,
        /// The least values.
        min: Config,
        /// The values at the start.
        dflt: Config,
    }
}

/// `dynamic_reconfigure/Reconfigure`: sets parameters and answers with all values that hold then.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reconfigure;

impl RosMsg for Reconfigure {
    fn encode<W: io::Write>(&self, _: W) -> io::Result<()> {
        Ok(())
    }

    fn decode<R: io::Read>(_: R) -> io::Result<Self> {
        Ok(Self)
    }
}

impl ServicePair for Reconfigure {
    // Request and response have one field each, which is such a message.
    type Request = Config;
    type Response = Config;
}

const CONFIG_FIELDS: &str =
    "BoolParameter[] bools\nIntParameter[] ints\nStrParameter[] strs\nDoubleParameter[] doubles\nGroupState[] groups\n";

/// The definitions that others are made of, by name.
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

impl Message for Config {
    fn msg_definition() -> String {
        with_parts(CONFIG_FIELDS, &PARTS[3..])
    }

    fn md5sum() -> String {
        "958f16a05573709014982821e6822580".to_owned()
    }

    fn msg_type() -> String {
        "dynamic_reconfigure/Config".to_owned()
    }
}

impl Message for ConfigDescription {
    fn msg_definition() -> String {
        with_parts("Group[] groups\nConfig max\nConfig min\nConfig dflt\n", &PARTS)
    }

    fn md5sum() -> String {
        "757ce9d44ba8ddd801bb30bc456f946f".to_owned()
    }

    fn msg_type() -> String {
        "dynamic_reconfigure/ConfigDescription".to_owned()
    }
}

impl Message for Reconfigure {
    fn msg_definition() -> String {
        "Config config\n---\nConfig config\n".to_owned()
    }

    fn md5sum() -> String {
        "bb125d226a21982a4a98760418dc2672".to_owned()
    }

    fn msg_type() -> String {
        "dynamic_reconfigure/Reconfigure".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
