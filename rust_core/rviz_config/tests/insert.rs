//! A camera is added to configs of all shapes, and everything else keeps its bytes.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use rcs_rviz_config::{insert_camera, parse, DisplaySettings, InsertError, NewCamera};

fn camera() -> NewCamera {
    NewCamera {
        name: "Projector".to_owned(),
        camera_info_topic: "/proj_view/camera_info".to_owned(),
        image_topic: "/proj_view/image".to_owned(),
        display_namespace: "proj_view".to_owned(),
        near_clip_m: 0.01,
    }
}

/// The text with a camera. What was inserted is one piece; without it, the text is what it was.
fn extended(text: &str, camera: &NewCamera) -> String {
    let extended = insert_camera(text, "a.rviz", camera).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let same = text.bytes().zip(extended.bytes()).take_while(|(before, after)| before == after).count();
    let inserted = extended.len() - text.len();
    // The insertion may begin earlier, with characters that the text goes on with.
    let (old, new) = (text.as_bytes(), extended.as_bytes());
    let is_one_piece = (0..=same).any(|at| new[..at] == old[..at] && new[at + inserted..] == old[at..]);
    assert!(is_one_piece, "{text}\n--- became\n{extended}");
    extended
}

#[test]
fn a_camera_is_added_in_the_style_of_the_list() {
    let tail = "  Enabled: true\n  Global Options:\n    Fixed Frame: map\nWindow Geometry: {}\n";
    let texts = [
        format!(
            "Visualization Manager:\n  Displays:\n    - Class: rviz/Grid\n      Name: g\n      Enabled: true\n{tail}"
        ),
        format!("Visualization Manager:\n  Displays:\n  - {{Class: rviz/Grid, Name: g, Enabled: true}}\n{tail}"),
        format!("Visualization Manager:\n  Displays:\n  # the floor\n\n  -   Class: rviz/Grid\n      Name: g\n{tail}"),
        format!("# é\nPanels:\n- {{Name: Displays}}\nVisualization Manager:\n  Class: ''\n  Displays: []\n{tail}"),
        format!("Visualization Manager:\n  Displays: [{{Class: rviz/Grid, Name: g}},\n    {{Class: rviz/TF}}]\n{tail}"),
        format!("Visualization Manager:\n  Displays:\n{tail}"),
        format!("Visualization Manager:\n  Displays:  # none yet\n{tail}"),
        format!("Visualization Manager:\n{tail}"),
        "Visualization Manager:\n  Enabled: true\n  Displays:".to_owned(),
        "Visualization Manager: {Enabled: true}\n".to_owned(),
        "Visualization Manager: {}\n".to_owned(),
        "Visualization Manager: {Displays: [], Enabled: true}\n".to_owned(),
        "{Visualization Manager: {Enabled: true, Displays: [{Class: rviz/Grid}]}}".to_owned(),
        "\u{feff}Visualization Manager:\n  Displays:\n    - Class: rviz/Grid\n".to_owned(),
        "Visualization Manager:\n  Displays:\n    - Class: rviz/Group\n      Displays:\n        - Class: rviz/Grid\n"
            .to_owned(),
    ];
    for text in texts {
        for text in [text.clone(), text.replace('\n', "\r\n")] {
            let before = parse(&text, "a.rviz").unwrap();
            let extended = extended(&text, &camera());
            let after = parse(&extended, "a.rviz").unwrap();
            assert_eq!(after.displays.len(), before.displays.len() + 1);
            assert_eq!(after.findings.len(), before.findings.len());
            assert!(matches!(&after.displays[0].settings, DisplaySettings::CameraPub(_)));
            if text.contains("\r\n") {
                assert_eq!(extended.matches('\n').count(), extended.matches("\r\n").count(), "{extended:?}");
            }
        }
    }
}

#[test]
fn a_null_is_replaced_by_a_list() {
    let text = "Visualization Manager:\n  Displays: ~\n  Enabled: true\n";
    let extended = insert_camera(text, "a.rviz", &camera()).unwrap();
    assert_eq!(parse(&extended, "a.rviz").unwrap().displays.len(), 1);
    assert!(
        extended.starts_with("Visualization Manager:\n  Displays: [{") && extended.ends_with("}]\n  Enabled: true\n")
    );
}

#[test]
fn names_that_yaml_would_take_for_something_else_are_quoted() {
    for name in
        ["true", "1", "a: b", "left, right", "say \"x\"", "back\\slash", "é", "- x", "#1", "two\nlines", " a ", "{"]
    {
        for text in [
            "Visualization Manager:\n  Displays: []\n",
            "Visualization Manager:\n  Displays:\n  - {Class: rviz/Grid}\n",
        ] {
            let camera = NewCamera { name: name.to_owned(), ..camera() };
            let extended = extended(text, &camera);
            assert_eq!(parse(&extended, "a.rviz").unwrap().displays[0].name, name);
        }
    }
}

#[test]
fn what_another_camera_has_is_refused_with_the_option_that_changes_it() {
    let text = insert_camera("Visualization Manager:\n  Displays: []\n", "a.rviz", &camera()).unwrap();
    let own = NewCamera {
        name: "Left".to_owned(),
        image_topic: "/left".to_owned(),
        display_namespace: "left".to_owned(),
        ..camera()
    };
    let taken = [
        (NewCamera { name: camera().name, ..own.clone() }, "--name"),
        (NewCamera { image_topic: camera().image_topic, ..own.clone() }, "--image-topic"),
        (NewCamera { display_namespace: camera().display_namespace, ..own.clone() }, "--display-namespace"),
    ];
    for (camera, word) in taken {
        let error = insert_camera(&text, "a.rviz", &camera).unwrap_err();
        assert!(matches!(&error, InsertError::Taken(text) if text.ends_with(word)), "{error}");
        assert!(error.to_string().starts_with("a.rviz: line 2: the CameraPub Projector"), "{error}");
    }
    assert_eq!(parse(&extended(&text, &own), "a.rviz").unwrap().displays.len(), 2);
}

/// It was refused as unusual YAML, because a finding was gone afterwards.
#[test]
fn a_camera_may_have_a_name_that_a_visibility_has_already() {
    let text = "Visualization Manager:\n  Displays:\n  - Class: rviz_camera_stream/CameraPub\n    Name: Left\n    \
                Enabled: true\n    Visibility: {Projector: false, Value: true}\n";
    assert_eq!(parse(text, "a.rviz").unwrap().findings.len(), 1);
    let after = parse(&extended(text, &camera()), "a.rviz").unwrap();
    assert_eq!((after.displays.len(), after.findings.len()), (2, 0));
}

#[test]
fn what_is_taken_is_one_line_whatever_the_names() {
    let name = "two\nlines";
    let text = insert_camera(
        "Visualization Manager:\n  Displays: []\n",
        "a.rviz",
        &NewCamera { name: name.to_owned(), ..camera() },
    )
    .unwrap();
    for name in [name, "Left"] {
        let error = insert_camera(&text, "a.rviz", &NewCamera { name: name.to_owned(), ..camera() }).unwrap_err();
        assert!(matches!(error, InsertError::Taken { .. }) && !error.to_string().contains('\n'), "{error}");
    }
}

#[test]
fn texts_that_cannot_be_extended_are_refused() {
    for text in [
        "Visualization Manager:\n  Displays: {a: b}\n",
        "Visualization Manager:\n  Displays: text\n",
        // Found by fuzzing: the `!` became a part of the camera's last value.
        "Visualization Manager:\n  Displays:\n             !  ",
        "Visualization Manager:\n  Displays:\n             &a\n",
        "x: &a [{Class: rviz/Grid}]\nVisualization Manager:\n  Displays: *a\n",
    ] {
        let error = insert_camera(text, "a.rviz", &camera()).unwrap_err();
        assert!(matches!(error, InsertError::Place { .. }), "{error}");
    }
    assert!(matches!(insert_camera("a: b", "a.rviz", &camera()).unwrap_err(), InsertError::Config(_)));
}
