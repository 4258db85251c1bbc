//! The paper's samples as nodes: `nav_path_markers`, `turret_aim`, `line_of_sight`.

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::master_and_python;

mod line_of_sight;
mod nav_path_markers;
mod turret_aim;

/// Python that reads messages by the definition that their sender gives, so that their package is not needed. genpy
/// computes the md5sum of the definition, which must be the sender's.
const DEFINED_BY_SENDER: &str = "
import genpy.dynamic
seen, headers = [], []
def see(message):
    header = message._connection_header
    headers.append(header)
    kind = genpy.dynamic.generate_dynamic(header['type'], header['message_definition'])[header['type']]
    assert kind._md5sum == header['md5sum'], (kind._md5sum, header['md5sum'])
    seen.append(kind().deserialize(message._buff))
";

/// One of the nodes, beside a master and a Python node.
struct Sample {
    python: PythonNode,
    node: Running,
    master: RosMaster,
}

impl Sample {
    /// Starts a node; `before` is Python that runs first.
    fn start(name: &str, before: &str, args: &[&str]) -> Self {
        let (master, python) = master_and_python(before);
        let node = Running::start(master.program(name).args(args)).unwrap();
        Self { python, node, master }
    }

    fn python(&self, code: &str) -> String {
        self.python.run(code).unwrap_or_else(|error| panic!("{error}\n{}", self.log()))
    }

    fn wait_for(&self, expression: &str) {
        let holds = self.python.wait_for(PATIENCE, expression);
        assert!(holds, "{expression}: {:?}\n{}", self.python.run(expression), self.log());
    }

    /// How a topic's last message looks to a node that starts now, by an expression of the message `m`.
    fn late(&self, topic: &str, expression: &str) -> String {
        let late = PythonNode::start(&self.master, &["__name:=late"]).unwrap();
        late.run(format!("{DEFINED_BY_SENDER}\nseeing = rospy.Subscriber({topic:?}, rospy.AnyMsg, see)")).unwrap();
        assert!(late.wait_for(PATIENCE, "len(seen) == 1"), "{topic}: {}", self.log());
        late.run(format!("(lambda m: {expression})(seen[-1])")).unwrap()
    }

    fn log(&self) -> String {
        [self.node.lines(), self.node.errors()].concat().join("\n")
    }

    /// Ends the node.
    fn end(&mut self) {
        let status = self.node.end("TERM").unwrap();
        assert!(status.success(), "{status}\n{}", self.log());
    }
}
