//! dynamic_reconfigure's parameters as JSON, both ways.

use rcs_messages::dynamic_reconfigure::{
    BoolParameter, Config, ConfigDescription, DoubleParameter, IntParameter, ParamDescription, StrParameter,
};
use rcs_ros::ReconfigureServer;
use serde_json::{json, Map, Value};

use crate::control::BLACKOUT;
use crate::outputs::parameter_description::choices;

/// A server with its parameters, as the pages show it.
pub(super) fn server(server: &ReconfigureServer, camera: &str) -> Value {
    let (description, config) = (server.description(), server.config());
    let parameters: Vec<_> =
        shown(description).map(|parameter| parameter_json(parameter, description, config)).collect();
    json!({"name": &**server.name(), "camera": camera, "parameters": parameters})
}

/// The parameters without the blackout: a page has buttons for that, of which only one can light.
fn shown(description: &ConfigDescription) -> impl Iterator<Item = &ParamDescription> {
    let all = description.groups.iter().flat_map(|group| &group.parameters);
    all.filter(|parameter| parameter.name != BLACKOUT)
}

fn parameter_json(parameter: &ParamDescription, description: &ConfigDescription, config: &Config) -> Value {
    let of = |values: &Config| value_of(values, &parameter.name);
    let is_number = matches!(parameter.r#type.as_str(), "int" | "double");
    let bound = |values: &Config| if is_number { of(values) } else { Value::Null };
    let choices = choices(&parameter.edit_method);
    let choices = choices.map(|choice| json!({"name": choice, "value": choice, "description": ""}));
    json!({
        "name": parameter.name,
        "type": parameter.r#type,
        "description": parameter.description,
        "min": bound(&description.min),
        "max": bound(&description.max),
        "default": of(&description.dflt),
        "value": of(config),
        "choices": choices.collect::<Vec<_>>(),
    })
}

fn value_of(values: &Config, name: &str) -> Value {
    let of_bool = values.bools.iter().find(|param| param.name == name).map(|param| json!(param.value));
    let of_int = values.ints.iter().find(|param| param.name == name).map(|param| json!(param.value));
    let of_str = values.strs.iter().find(|param| param.name == name).map(|param| json!(param.value));
    let of_double = values.doubles.iter().find(|param| param.name == name).map(|param| json!(param.value));
    of_bool.or(of_int).or(of_str).or(of_double).unwrap_or_default()
}

/// The values of a page's request, typed as the server has them.
///
/// # Errors
/// The parameter whose value has another type, or that the server does not have.
pub(super) fn request(values: &Map<String, Value>, server: &ReconfigureServer) -> Result<Config, String> {
    typed(values, server.description())
}

fn typed(values: &Map<String, Value>, description: &ConfigDescription) -> Result<Config, String> {
    let mut request = Config::default();
    for (name, value) in values {
        let known = shown(description).find(|parameter| parameter.name == *name);
        let kind = known.ok_or_else(|| format!("there is no parameter {name}"))?.r#type.as_str();
        let wrong = || format!("{name}: {value} is no {kind}");
        let name = name.clone();
        match kind {
            "bool" => request.bools.push(BoolParameter { name, value: value.as_bool().ok_or_else(wrong)? }),
            "int" => {
                let value = value.as_i64().and_then(|value| i32::try_from(value).ok()).ok_or_else(wrong)?;
                request.ints.push(IntParameter { name, value });
            }
            "double" => request.doubles.push(DoubleParameter { name, value: value.as_f64().ok_or_else(wrong)? }),
            _ => request.strs.push(StrParameter { name, value: value.as_str().ok_or_else(wrong)?.to_owned() }),
        }
    }
    Ok(request)
}

#[cfg(test)]
mod tests {
    use rcs_messages::dynamic_reconfigure::Group;

    use super::*;
    use crate::outputs::parameter_description::{choice_of, parameter};

    fn description() -> ConfigDescription {
        let parameters = vec![
            parameter(BLACKOUT, "bool", "", String::new()),
            parameter("show", "bool", "", String::new()),
            parameter("rate", "double", "Images a second", String::new()),
            parameter("red", "int", "", String::new()),
            parameter("encoding", "str", "", choice_of("Encoding", ["rgb8", "mono8"])),
        ];
        let bound =
            |value| Config { doubles: vec![DoubleParameter { name: "rate".to_owned(), value }], ..Config::default() };
        let groups = vec![Group { parameters, ..Group::default() }];
        ConfigDescription { groups, max: bound(100.0), min: bound(-1.0), dflt: bound(30.0) }
    }

    #[test]
    fn values_have_the_types_of_their_parameters() {
        let typed = |text: &str| typed(&serde_json::from_str(text).unwrap(), &description());
        let all = typed(r#"{"show": false, "rate": 15, "red": 3, "encoding": "mono8"}"#).unwrap();
        assert_eq!((all.bools[0].value, all.doubles[0].value, all.ints[0].value), (false, 15.0, 3));
        assert_eq!(all.strs[0].value, "mono8");
        assert_eq!(typed(r#"{"show": 1}"#).unwrap_err(), "show: 1 is no bool");
        assert_eq!(typed(r#"{"red": 3000000000}"#).unwrap_err(), "red: 3000000000 is no int");
        assert_eq!(typed(r#"{"other": 1}"#).unwrap_err(), "there is no parameter other");
        assert_eq!(typed(r#"{"blackout": false}"#).unwrap_err(), "there is no parameter blackout");
    }

    #[test]
    fn a_parameter_tells_its_bounds_and_choices() {
        let description = description();
        let values =
            Config { doubles: vec![DoubleParameter { name: "rate".to_owned(), value: 5.0 }], ..Config::default() };
        let json = |index: usize| parameter_json(shown(&description).nth(index).unwrap(), &description, &values);
        let rate = json(1);
        assert_eq!([&rate["min"], &rate["max"], &rate["default"], &rate["value"]], [-1.0, 100.0, 30.0, 5.0]);
        let encoding = json(3);
        assert_eq!((&encoding["min"], &encoding["choices"][1]["value"]), (&Value::Null, &json!("mono8")));
    }
}
