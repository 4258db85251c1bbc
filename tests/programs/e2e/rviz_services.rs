//! rviz's services for configs, called as scripts call rviz's.

use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};
use std::fs;

/// `rviz/SendFilePath`, of which Debian has no Python module, and calls that print what rviz would have answered.
const CALLS: &str = "
import genpy, struct
from std_srvs.srv import Empty
from dynamic_reconfigure.client import Client
SUM = '92f17244ff295b327b62c307fafe751b'
class Request(genpy.Message):
    _type, _md5sum, _slot_types, __slots__ = 'rviz/SendFilePathRequest', SUM, ['string'], ['path']
    def serialize(self, buff): buff.write(struct.pack('<I', len(self.path)) + self.path.encode())
class Response(genpy.Message):
    _type, _md5sum, _slot_types, __slots__ = 'rviz/SendFilePathResponse', SUM, ['bool'], ['success']
    def deserialize(self, data): self.success = bool(data[0]); return self
class SendFilePath: _type, _md5sum, _request_class, _response_class = 'rviz/SendFilePath', SUM, Request, Response
def send(name, path): return rospy.ServiceProxy('/camera_stream/' + name, SendFilePath)(path).success
def red(level): Client('/camera_stream/CameraPub', timeout=300).update_configuration({'background_red': level})
def corner(): return viewer.pixel(1, 1)
";

fn of_background(background: &'static str) -> String {
    config(&[CLOUD], &[CameraPub { background, ..CameraPub::default() }])
}

fn fixture(args: &[&str]) -> RosFixture {
    let fixture = Setup::with_config(of_background("0; 0; 0")).args(args).start();
    fixture.python("place_camera(); latch('/cloud', cloud(0xff0000))");
    fixture.python(CALLS);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and corner() == (0, 0, 0)");
    fixture
}

#[test]
fn another_config_is_loaded_and_one_that_cannot_be_read_is_not() {
    let fixture = fixture(&["--no-watch"]);
    let folder = tempfile::tempdir().unwrap();
    let [blue, wrong, gone] = ["blue.rviz", "wrong.rviz", "gone.rviz"].map(|name| folder.path().join(name));
    fs::write(&blue, of_background("0; 0; 255")).unwrap();
    fs::write(&wrong, "Visualization Manager: [").unwrap();
    assert_eq!(fixture.python(format!("send('load_config', '{}')", blue.display())), "True");
    fixture.wait_for("corner() == (0, 0, 255)");
    for file in [&wrong, &gone, &folder.path().to_owned()] {
        for service in ["load_config", "load_config_discarding_changes"] {
            assert_eq!(fixture.python(format!("send('{service}', '{}')", file.display())), "False", "{file:?}");
        }
    }
    fixture.wait_for_log("not loaded, so the previous config is kept: ").unwrap();
    // The loaded file is the config from then on.
    fs::write(&blue, of_background("0; 255; 0")).unwrap();
    fixture.python("trigger('/camera_stream/reload_config')");
    fixture.wait_for("corner() == (0, 255, 0)");
    fixture.python("rospy.ServiceProxy('/camera_stream/reload_shaders', Empty)()");
}

#[test]
fn changed_settings_are_saved_and_not_lost_unless_they_are_to_be() {
    let fixture = fixture(&[]);
    let folder = tempfile::tempdir().unwrap();
    let saved = folder.path().join("saved.rviz");
    let send =
        |service: &str, file: &std::path::Path| fixture.python(format!("send('{service}', '{}')", file.display()));
    let first = fixture.config_file();
    fixture.python("red(9)");
    fixture.wait_for("corner() == (9, 0, 0)");
    assert_eq!(send("load_config", &first), "False");
    fixture.wait_for_log("changed and not saved; call save_config").unwrap();
    assert_eq!(send("save_config", &folder.path().join("no/such/folder.rviz")), "False");
    let other = folder.path().join(".bashrc");
    assert_eq!(send("save_config", &other), "False", "no config");
    assert!(!other.exists());
    assert_eq!(send("load_config", &first), "False", "still not saved");
    assert_eq!(send("save_config", &saved), "True");
    assert!(fs::read_to_string(&saved).unwrap().contains("Background Color: 9; 0; 0\n"));
    assert_eq!(send("load_config", &first), "True");
    fixture.wait_for("corner() == (0, 0, 0)");
    assert_eq!(send("load_config", &saved), "True");
    fixture.wait_for("corner() == (9, 0, 0)");
    fixture.python("red(99)");
    fixture.wait_for("corner() == (99, 0, 0)");
    assert_eq!(send("load_config_discarding_changes", &saved), "True");
    fixture.wait_for("corner() == (9, 0, 0)");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
}
