//! Types, checksums and definitions are those that ROS has.

use rcs_messages::MessageKind;
use rcs_tests::ros::RosMaster;

#[test]
fn checksums_are_those_of_rosmsg() {
    let master = RosMaster::reserve().unwrap();
    for kind in MessageKind::ALL {
        let said = master.output("rosmsg", &["md5", kind.ros_type()]).unwrap();
        assert_eq!(said.trim(), kind.md5sum(), "{}", kind.ros_type());
    }
}

/// Recorders write the definition into bags, from which other tools make the type anew.
#[test]
fn definitions_make_the_same_types() {
    let script = "import sys, genpy.dynamic\n\
                  name = sys.argv[1]\n\
                  print(genpy.dynamic.generate_dynamic(name, sys.argv[2])[name]._md5sum)\n";
    let master = RosMaster::reserve().unwrap();
    for kind in MessageKind::ALL {
        let said = master.output("python3", &["-c", script, kind.ros_type(), &kind.definition()]).unwrap();
        assert_eq!(said.trim(), kind.md5sum(), "{}", kind.ros_type());
    }
}
