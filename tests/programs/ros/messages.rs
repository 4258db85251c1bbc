//! Types, checksums and definitions are those that ROS has.

use rcs_messages::dynamic_reconfigure::{
    BoolParameter, Config, ConfigDescription, DoubleParameter, Group, GroupState, IntParameter, ParamDescription,
    Reconfigure, StrParameter,
};
use rcs_messages::{Message, MessageKind};
use rcs_tests::ros::RosMaster;

#[test]
fn checksums_are_those_of_rosmsg() {
    let master = RosMaster::reserve().unwrap();
    for kind in MessageKind::ALL {
        let printed = master.output("rosmsg", &["md5", kind.ros_type()]).unwrap();
        assert_eq!(printed.trim(), kind.md5sum(), "{}", kind.ros_type());
    }
}

/// Recorders write the definition into bags, from which other tools make the type anew.
#[test]
fn message_definitions_have_the_checksums_of_ros() {
    let script = "import sys, genpy.dynamic\n\
                  name = sys.argv[1]\n\
                  print(genpy.dynamic.generate_dynamic(name, sys.argv[2])[name]._md5sum)\n";
    let master = RosMaster::reserve().unwrap();
    for kind in MessageKind::ALL {
        let printed = master.output("python3", &["-c", script, kind.ros_type(), &kind.definition()]).unwrap();
        assert_eq!(printed.trim(), kind.md5sum(), "{}", kind.ros_type());
    }
}

/// These are written by hand, for the package need not be there when the programs are built.
#[test]
fn dynamic_reconfigure_messages_are_those_of_ros() {
    let master = RosMaster::reserve().unwrap();
    let python = |script: &str, args: &[&str]| {
        let printed = master.output("python3", &[&["-c", script], args].concat()).unwrap();
        printed.trim().to_owned()
    };
    let script = "from dynamic_reconfigure.msg import *; from dynamic_reconfigure.srv import *\n\
                  print(Config._md5sum, ConfigDescription._md5sum, Reconfigure._md5sum)";
    let own = [Config::md5sum(), ConfigDescription::md5sum(), Reconfigure::md5sum()].join(" ");
    assert_eq!(python(script, &[]), own);
    let script = "import sys, genpy.dynamic\n\
                  name = sys.argv[1]\n\
                  print(genpy.dynamic.generate_dynamic(name, sys.argv[2])[name]._md5sum)\n";
    for (name, definition, md5sum) in [
        (Config::msg_type(), Config::msg_definition(), Config::md5sum()),
        (ConfigDescription::msg_type(), ConfigDescription::msg_definition(), ConfigDescription::md5sum()),
    ] {
        assert_eq!(python(script, &[&name, &definition]), md5sum, "{name}");
    }

    let name = |name: &str| name.to_owned();
    let config = Config {
        bools: vec![BoolParameter { name: name("b"), value: true }],
        ints: vec![IntParameter { name: name("i"), value: -3 }],
        strs: vec![StrParameter { name: name("s"), value: name("text") }],
        doubles: vec![DoubleParameter { name: name("d"), value: 0.25 }],
        groups: vec![GroupState { name: name("g"), state: true, id: 1, parent: 2 }],
    };
    let parameter = ParamDescription {
        name: name("p"),
        r#type: name("str"),
        level: 7,
        description: name("words"),
        edit_method: name("{}"),
    };
    let group = Group { name: name("g"), r#type: name("tab"), parameters: vec![parameter], parent: 5, id: 6 };
    let description =
        ConfigDescription { groups: vec![group], max: config, min: Config::default(), dflt: Config::default() };
    let hex: String = rcs_messages::encode(&description).iter().map(|byte| format!("{byte:02x}")).collect();
    let script = "import sys; from dynamic_reconfigure.msg import *\n\
                  c = Config([BoolParameter('b', True)], [IntParameter('i', -3)], [StrParameter('s', 'text')], \
                  [DoubleParameter('d', 0.25)], [GroupState('g', True, 1, 2)])\n\
                  p = ParamDescription('p', 'str', 7, 'words', '{}')\n\
                  d = ConfigDescription([Group('g', 'tab', [p], 5, 6)], c, Config(), Config())\n\
                  print(d == ConfigDescription().deserialize(bytes.fromhex(sys.argv[1])))";
    assert_eq!(python(script, &[&hex]), "True");
}
