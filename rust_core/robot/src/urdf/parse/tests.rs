//! Descriptions, sound and damaged.

use nalgebra::Vector3;

use super::*;
use crate::JointKind;

fn robot(inside: &str) -> Result<Robot, UrdfError> {
    parse(&format!("<?xml version=\"1.0\"?>\n<robot name=\"r\">\n{inside}\n</robot>"))
}

const BOX: &str = "<geometry><box size=\"1 2 3\"/></geometry>";

#[test]
fn a_material_is_that_of_the_first_definition_of_its_name() {
    let robot = robot(&format!(
        "<material name=\"a\"><color rgba=\"1 0 0 0.5\"/></material>
        <link name=\"x\"><visual>{BOX}<material name=\"a\"><color rgba=\"0 1 0 1\"/></material></visual>
        <visual>{BOX}<material name=\"b\"><texture filename=\"package://p/t.png\"/></material></visual></link>
        <link name=\"y\"><visual>{BOX}<material name=\"b\"/></visual><visual>{BOX}<material name=\"c\"/></visual></link>
        <joint name=\"j\" type=\"fixed\"><parent link=\"x\"/><child link=\"y\"/></joint>"
    ))
    .unwrap();
    let [x, y] = ["x", "y"].map(|link| &robot.links[link].visuals);
    assert_eq!(x[0].material.as_ref().unwrap().rgba, [1.0, 0.0, 0.0, 0.5], "the robot's, not the visual's own");
    assert_eq!(x[1].material.as_ref().unwrap().texture, "package://p/t.png");
    assert_eq!(y[0].material, x[1].material);
    assert_eq!((y[1].material_name.as_str(), &y[1].material), ("c", &None));
    let faults: Vec<String> = robot.left_out.iter().map(ToString::to_string).collect();
    assert_eq!(faults, ["line 6: link \"y\": its material \"c\" is defined nowhere"]);
}

#[test]
fn colours_that_are_not_four_numbers_are_black_or_no_colours() {
    let visual = |rgba: &str| {
        let material = format!("<material name=\"m\"><color rgba=\"{rgba}\"/></material>");
        let robot = robot(&format!("<link name=\"x\"><visual>{BOX}{material}</visual></link>")).unwrap();
        robot.links["x"].visuals[0].material.as_ref().map(|material| material.rgba)
    };
    assert_eq!(visual("0.1 0.2 0.3 1"), Some([0.1, 0.2, 0.3, 1.0]));
    assert_eq!(visual("1 0 0"), Some([0.0, 0.0, 0.0, 1.0]));
    assert_eq!(visual("255 0 0 1"), None);
    assert_eq!(visual("red"), None);
}

#[test]
fn a_shape_that_cannot_be_read_ends_its_link_but_not_the_robot() {
    let robot = robot(&format!(
        "<link name=\"x\"><visual>{BOX}</visual>
        <visual><geometry><sphere radius=\"big\"/></geometry></visual>
        <visual>{BOX}</visual><collision>{BOX}</collision></link>"
    ))
    .unwrap();
    let link = &robot.links["x"];
    assert_eq!((link.visuals.len(), link.collisions.len(), link.has_first_visual), (1, 0, false));
    assert_eq!(robot.left_out[0].to_string(), "line 4: link \"x\": sphere: radius=\"big\" is not a number");
}

#[test]
fn descriptions_that_urdfdom_refuses_are_refused_with_line_and_element() {
    let link = |name: &str| format!("<link name=\"{name}\"/>");
    let joint = |inside: &str| {
        let ends = "<parent link=\"a\"/><child link=\"b\"/>";
        format!("{}{}<joint name=\"j\" type=\"revolute\">{ends}{inside}</joint>", link("a"), link("b"))
    };
    for (inside, expected) in [
        (String::new(), "line 2: robot \"r\": it has no links"),
        (link("a") + &link("a"), "line 3: link \"a\": its name occurs twice"),
        (link("a") + &link("b"), "line 2: robot \"r\": the links \"a\" and \"b\" both hang on no joint"),
        (joint(""), "line 3: joint \"j\": joint \"j\": it has no limits"),
        (joint("<limit effort=\"1\"/>"), "line 3: joint \"j\": limit: it has no attribute velocity"),
        (joint("<limit effort=\"x\" velocity=\"1\"/>"), "line 3: joint \"j\": limit: effort=\"x\" is not a number"),
        ("<link name=\"a\">".to_owned(), "line 4: XML"),
    ] {
        let error = robot(&inside).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    assert!(parse("").is_err() && parse("<robot/>").is_err() && parse("<a/>").is_err() && parse("rubbish").is_err());
    let deep = "<a>".repeat(100_000);
    assert!(parse(&deep).unwrap_err().to_string().contains("nested deeper"));
}

#[test]
fn a_byte_order_mark_before_the_description_changes_nothing() {
    let text = "<?xml version=\"1.0\"?>\n<robot name=\"r\"><link name=\"x\"/></robot>";
    let links = parse(&format!("\u{feff}{text}")).unwrap().links;
    assert_eq!((links.len(), links), (1, parse(text).unwrap().links));
}

#[test]
fn unknown_elements_are_skipped() {
    let text =
        "<!DOCTYPE robot><!-- c --><robot name=\"r\" xmlns:q=\"q\"><gazebo:x y:z=\"1\"><b>t &amp; u</b></gazebo:x>
        <link name=\"a&amp;b\"/><transmission/></robot>";
    assert!(parse(text).unwrap().links.contains_key("a&b"));
}

#[test]
fn what_urdfdom_passes_over_is_noted() {
    for (inside, after, noted) in [
        ("<gazebo>a & b</gazebo>", "", Some(3)),
        ("<gazebo>&nbsp;</gazebo>", "", Some(3)),
        ("<gazebo a=\"x & y\"/>", "", Some(3)),
        ("<gazebo a=b/>", "", Some(3)),
        ("<gazebo a=\"<x>\"/>", "", None),
        ("<!-- a -- b -->", "", Some(3)),
        ("", "\n<!-- not closed", Some(4)),
    ] {
        let text = format!("\n<robot name=\"r\">\n{inside}<link name=a/></robot>{after}");
        let robot = parse(&text.replace("name=a", "name='a'")).unwrap();
        assert!(robot.links.contains_key("a"));
        assert_eq!(robot.passed_over.first().map(|fault| fault.line), noted, "{text}");
        assert!(parse(&text).unwrap().links.contains_key("a"));
    }
    for refused in ["<gazebo><!-- a </gazebo>", "<gazebo></gazeb>", "<gazebo>", "<gazebo>a < b</gazebo>"] {
        assert!(robot(&format!("<link name='a'/>{refused}")).is_err(), "{refused}");
    }
}

#[test]
fn joints_have_axis_and_largest_effort() {
    let robot = robot(
        "<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>
        <joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 1 0\"/>
        <limit lower=\"-1\" upper=\"1\" effort=\"30\" velocity=\"1\"/></joint>
        <joint name=\"k\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/></joint>",
    )
    .unwrap();
    let [j, k] = ["j", "k"].map(|name| &robot.joints[name]);
    assert_eq!((j.kind, j.axis, j.max_effort), (JointKind::Revolute, Vector3::y(), Some(30.0)));
    assert_eq!((k.kind, k.axis, k.max_effort), (JointKind::Continuous, Vector3::x(), None));
}
