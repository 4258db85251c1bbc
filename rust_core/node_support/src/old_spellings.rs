//! Spellings of options that were replaced by others. They go on for one version, with a warning each.

use std::ffi::OsString;

/// Parameters that have another name now.
const PARAMETERS: [(&str, &str); 1] = [("mesh_folders", "mesh_folder")];

/// The name and value of an option that replace an old spelling; no value for a switch. `None` where it is current.
fn replacement<'v>(option: &str, value: &'v str) -> Option<(&'static str, Option<&'v str>)> {
    Some(match (option, value) {
        ("frames", folder) => ("sequence", Some(folder)),
        ("stale-timeout", limit) if limit.contains('=') => ("stale-timeouts", Some(limit)),
        ("stale-timeout", "never") => ("stale-timeout", Some("none")),
        ("predict", "off" | "false") => ("predict", Some("none")),
        ("mask-required", "true") => ("mask-required", None),
        ("mask-required", "false") => ("no-mask-required", None),
        ("fixed-frame", "auto" | "") => ("fixed-frame", Some("none")),
        ("mask-topic", "") => ("mask-topic", Some("none")),
        ("keep-out", "") => ("keep-out", Some("none")),
        ("mask", "") => ("mask", Some("none")),
        ("blend", "") => ("blend", Some("none")),
        ("window", "") => ("window", Some("none")),
        ("stale-timeouts", "") => ("stale-timeouts", Some("none")),
        _ => return None,
    })
}

/// The current name of a parameter.
pub fn parameter<'n>(name: &'n str, warnings: &mut Vec<String>) -> &'n str {
    let Some((_, current)) = PARAMETERS.iter().find(|(old, _)| *old == name) else { return name };
    warnings.push(format!("~{name} is an old name; write ~{current}"));
    current
}

/// The words of a command line in current spellings.
pub fn command_line(words: Vec<OsString>, warnings: &mut Vec<String>) -> Vec<OsString> {
    let mut current = Vec::new();
    let mut words = words.into_iter().peekable();
    while let Some(word) = words.next() {
        let option = word.to_str().and_then(|text| text.strip_prefix("--")).unwrap_or_default();
        let (option, inline) = match option.split_once('=') {
            Some((option, value)) => (option, Some(value)),
            None => (option, None),
        };
        let next = words.peek().and_then(|next| next.to_str());
        let Some((name, value)) = inline.or(next).and_then(|value| replacement(option, value)) else {
            current.push(word);
            continue;
        };
        let new = [Some(format!("--{name}")), value.map(str::to_owned)];
        let old = inline.or(next).unwrap_or_default();
        let text = new.iter().flatten().cloned().collect::<Vec<_>>().join(" ");
        warnings.push(format!("'--{option} {old}' is an old spelling; write '{text}'"));
        current.extend(new.into_iter().flatten().map(OsString::from));
        if inline.is_none() {
            words.next();
        }
    }
    current
}

/// The option and value that stand for a parameter's text.
pub fn value<'v>(option: &'v str, text: &'v str, warnings: &mut Vec<String>) -> (&'v str, &'v str) {
    let Some((name, Some(value))) = replacement(option, text) else { return (option, text) };
    let parameter = |option: &str| option.replace('-', "_");
    let (old, new) = (parameter(option), parameter(name));
    warnings.push(format!("'~{old}: {text}' is an old spelling; write '~{new}: {value}'"));
    (name, value)
}

/// The elements of a text that was one for several, `A=1 B=2`, or one `A=1` where a struct is due now.
pub fn elements<'t>(parameter: &str, text: &'t str, fields: &str, warnings: &mut Vec<String>) -> Vec<&'t str> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_old =
        !words.is_empty() && words.iter().all(|word| word.contains('=')) && !std::path::Path::new(text).exists();
    if !is_old {
        return vec![text];
    }
    warnings.push(format!("'~{parameter}: {text}' is an old spelling; write a list of {fields}"));
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_command_line_goes_on_with_a_warning_for_each_word() {
        let mut warnings = Vec::new();
        let words =
            "x --stale-timeout /map=held --mask-required=false --mask-required true --frames d --predict off -d \
                     --stale-timeout 1 --splash-screen";
        let words = command_line(words.split_whitespace().map(OsString::from).collect(), &mut warnings);
        let expected =
            "x --stale-timeouts /map=held --no-mask-required --mask-required --sequence d --predict none -d \
                        --stale-timeout 1 --splash-screen";
        assert_eq!(words, expected.split_whitespace().map(OsString::from).collect::<Vec<_>>());
        assert_eq!(warnings.len(), 5, "{warnings:?}");
        let first = "'--stale-timeout /map=held' is an old spelling; write '--stale-timeouts /map=held'";
        assert_eq!(warnings[0], first);
    }

    #[test]
    fn old_texts_of_a_parameter_go_on_with_a_warning() {
        let mut warnings = Vec::new();
        assert_eq!(elements("keep_out", "a=1  b=2", "{frame, radius}", &mut warnings), ["a=1", "b=2"]);
        assert_eq!(elements("mask", "/a file.png", "{camera, file}", &mut warnings), ["/a file.png"]);
        assert_eq!(parameter("mesh_folders", &mut warnings), "mesh_folder");
        assert_eq!(value("fixed-frame", "auto", &mut warnings), ("fixed-frame", "none"));
        assert_eq!(warnings.len(), 3, "{warnings:?}");
    }
}
