//! The settings of dynamic_reconfigure as JSON, both ways.

use rcs_ros::settings::{settings, NamedValues, Setting, SettingGroup};
use rcs_ros::{ParameterValue, ReconfigureServer};
use serde_json::{json, Map, Value};

use crate::control::BLACKOUT;

/// A server with its settings, as the pages show it.
pub(super) fn server(server: &ReconfigureServer, camera: &str) -> Value {
    let parameters: Vec<_> = shown(server.groups()).map(setting_json).collect();
    json!({"name": &**server.name(), "camera": camera, "parameters": parameters})
}

/// The settings without the blackout: a page has buttons for that, of which only one can light.
fn shown(groups: &[SettingGroup]) -> impl Iterator<Item = &Setting> {
    settings(groups).filter(|setting| setting.name != BLACKOUT)
}

fn setting_json(setting: &Setting) -> Value {
    let is_number = matches!(setting.value, ParameterValue::Int(_) | ParameterValue::Double(_));
    let [min, max] = setting.range.each_ref().map(|bound| if is_number { value_json(bound) } else { Value::Null });
    let choices = setting.choices.iter().map(|choice| json!({"name": choice, "value": choice, "description": ""}));
    json!({
        "name": setting.name,
        "label": setting.label.0,
        "unit": setting.label.1,
        "type": setting.kind(),
        "description": setting.description,
        "min": min,
        "max": max,
        "default": value_json(&setting.default),
        "value": value_json(&setting.value),
        "choices": choices.collect::<Vec<_>>(),
    })
}

fn value_json(value: &ParameterValue) -> Value {
    match value {
        ParameterValue::Bool(value) => json!(value),
        ParameterValue::Int(value) => json!(value),
        ParameterValue::Double(value) => json!(value),
        text => json!(text.text()),
    }
}

/// The values of a page's request, typed as the settings are.
///
/// # Errors
/// The setting whose value has another type, or that there is not.
pub(super) fn request(values: &Map<String, Value>, groups: &[SettingGroup]) -> Result<NamedValues, String> {
    let typed = |(name, value): (&String, &Value)| {
        let known = shown(groups).find(|setting| setting.name == *name);
        let setting = known.ok_or_else(|| format!("there is no parameter {name}"))?;
        let typed = match setting.value {
            ParameterValue::Bool(_) => value.as_bool().map(ParameterValue::Bool),
            ParameterValue::Int(_) => value.as_i64().and_then(|value| value.try_into().ok()).map(ParameterValue::Int),
            ParameterValue::Double(_) => value.as_f64().map(ParameterValue::Double),
            _ => value.as_str().map(ParameterValue::from),
        };
        Ok((name.clone(), typed.ok_or_else(|| format!("{name}: {value} is no {}", setting.kind()))?))
    };
    values.iter().map(typed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn groups() -> [SettingGroup; 1] {
        let settings = vec![
            Setting::switch(BLACKOUT, "", [false; 2]),
            Setting::switch("show", "", [true; 2]),
            Setting::new("rate", "Images a second", [5.0, 30.0], [-1.0, 100.0]),
            Setting::new("red", "", [0; 2], [0, 255]),
            Setting::choice("encoding", "Encoding", ["rgb8"; 2], vec!["rgb8", "mono8"]),
        ];
        [("Default", settings)]
    }

    #[test]
    fn values_have_the_types_of_their_parameters() {
        let typed = |text: &str| request(&serde_json::from_str(text).unwrap(), &groups());
        let all = typed(r#"{"show": false, "rate": 15, "red": 3, "encoding": "mono8"}"#).unwrap();
        let of = |name: &str| all.iter().find(|(known, _)| known == name).unwrap().1.clone();
        assert_eq!([of("show"), of("rate")], [false.into(), 15.0.into()]);
        assert_eq!([of("red"), of("encoding")], [3.into(), "mono8".into()]);
        assert_eq!(typed(r#"{"show": 1}"#).unwrap_err(), "show: 1 is no bool");
        assert_eq!(typed(r#"{"red": 3000000000}"#).unwrap_err(), "red: 3000000000 is no int");
        assert_eq!(typed(r#"{"other": 1}"#).unwrap_err(), "there is no parameter other");
        assert_eq!(typed(r#"{"blackout": false}"#).unwrap_err(), "there is no parameter blackout");
    }

    #[test]
    fn a_parameter_tells_its_bounds_and_choices() {
        let groups = groups();
        let json = |index: usize| setting_json(shown(&groups).nth(index).unwrap());
        let rate = json(1);
        assert_eq!([&rate["min"], &rate["max"], &rate["default"], &rate["value"]], [-1.0, 100.0, 30.0, 5.0]);
        let encoding = json(3);
        assert_eq!((&encoding["min"], &encoding["choices"][1]["value"]), (&Value::Null, &json!("mono8")));
    }
}
