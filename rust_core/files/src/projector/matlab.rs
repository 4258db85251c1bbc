//! MATLAB scripts of calibration toolboxes, with the projector as the right one of two cameras or as the only one.
//!
//! Statements such as `fc = [ 1 ; 2 ];` are read, also over several lines (`...`). Nothing is computed: a variable that
//! is needed and not plain numbers is an error.

use serde_yaml_ng::Mapping;

use super::key_error::KeyError;
use super::own_form::own_form;
use crate::yaml_text::beginning;

/// Values of a script by this project's keys; `None` if it sets none of the toolboxes' variables.
///
/// # Errors
/// A variable that is computed or has another number of values than the toolbox writes.
pub(super) fn values(text: &str) -> Result<Option<Mapping>, KeyError> {
    let code = code_of(text);
    let script = Script { assignments: assignments(&code) };
    let (tool, f, c, alpha, d) = if let (Some(f), Some(c)) = (script.exactly("fc_right")?, script.exactly("cc_right")?)
    {
        let [alpha] = script.exactly("alpha_c_right")?.unwrap_or([0.0]);
        if alpha != 0.0 {
            let reason =
                format!("it is {alpha}, a skew in pixels or in focal lengths, depending on the program: write K");
            return Err(("alpha_c_right", reason));
        }
        ("scan3d-capture", f, c, 0.0, script.numbers("kc_right")?)
    } else if let (Some(f), Some(c)) = (script.exactly("fc")?, script.exactly("cc")?) {
        let [alpha] = script.exactly("alpha_c")?.unwrap_or([0.0]);
        ("Bouguet's toolbox", f, c, alpha, script.numbers("kc")?)
    } else {
        return Ok(None);
    };
    let ([fx, fy], [cx, cy]): ([f64; 2], [f64; 2]) = (f, c);
    let k = vec![fx, alpha * fx, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
    let size = match script.exactly("nx")?.zip(script.exactly("ny")?) {
        Some(size) => Some(size),
        None => script.exactly("width")?.zip(script.exactly("height")?),
    };
    let size = size.map(|([width], [height])| (width.into(), height.into()));
    own_form(&Mapping::new(), tool, k, d.unwrap_or_default(), size).map(Some)
}

/// Variables with the text that they are set to, in the order of the script.
struct Script<'a> {
    assignments: Vec<(&'a str, &'a str)>,
}

impl Script<'_> {
    /// The numbers that a variable is last set to; `None` if it is not set.
    fn numbers(&self, name: &'static str) -> Result<Option<Vec<f64>>, KeyError> {
        let Some((_, set_to)) = self.assignments.iter().rev().find(|(set, _)| *set == name) else { return Ok(None) };
        plain_numbers(set_to).map(Some).ok_or_else(|| {
            (name, format!("the MATLAB script computes it ('{}'): write its numbers", beginning(set_to)))
        })
    }

    /// The `N` numbers that a variable is last set to; `None` if it is not set.
    fn exactly<const N: usize>(&self, name: &'static str) -> Result<Option<[f64; N]>, KeyError> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        let wrong = |numbers: Vec<f64>| (name, format!("{} numbers in the MATLAB script, not {N}", numbers.len()));
        numbers.try_into().map(Some).map_err(wrong)
    }
}

/// The script without comments and without what is in quotes; lines that are continued are joined.
fn code_of(text: &str) -> String {
    let (mut code, mut open_blocks) = (String::new(), 0_usize);
    for line in text.lines() {
        match line.trim() {
            "%{" => open_blocks += 1,
            "%}" => open_blocks = open_blocks.saturating_sub(1),
            _ if open_blocks == 0 => add_line(&mut code, line),
            _ => {}
        }
    }
    code
}

/// Adds the code of a line.
fn add_line(code: &mut String, line: &str) {
    // Behind these an apostrophe transposes.
    let is_operand = |c: char| c.is_ascii_alphanumeric() || "_)]}.'".contains(c);
    let mut open_quote = None;
    for (at, c) in line.char_indices() {
        match (open_quote, c) {
            (Some(quote), _) if c == quote => open_quote = None,
            (Some(_), _) => {}
            (None, '%' | '#') => break,
            (None, '.') if line[at..].starts_with("...") => {
                code.push(' ');
                return;
            }
            (None, '"') => open_quote = Some(c),
            (None, '\'') if !code.ends_with(is_operand) => open_quote = Some(c),
            _ => code.push(c),
        }
        // Text is no number.
        if open_quote == Some(c) {
            code.push('"');
        }
    }
    code.push('\n');
}

/// Each variable that a statement sets, with what it is set to; the whole statement if it sets only a part of it, or
/// others with it.
fn assignments(code: &str) -> Vec<(&str, &str)> {
    let mut depth = 0_usize;
    let ends_statement = |c: char| {
        match c {
            '[' | '(' | '{' => depth += 1,
            ']' | ')' | '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0 && matches!(c, ';' | ',' | '\n')
    };
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut set = Vec::new();
    for statement in code.split(ends_statement) {
        let Some((target, value)) = statement.split_once('=') else { continue };
        let target = target.trim();
        if target.chars().all(is_of_name) {
            set.push((target, value.trim()));
        } else {
            let names = target.split(|c| !is_of_name(c)).filter(|name| !name.is_empty());
            set.extend(names.map(|name| (name, statement.trim())));
        }
    }
    set
}

/// A number, or a list of numbers in brackets, which may be transposed.
fn plain_numbers(text: &str) -> Option<Vec<f64>> {
    let untransposed = text.strip_suffix('\'').map_or(text, |text| text.strip_suffix('.').unwrap_or(text));
    let Some(list) = untransposed.strip_prefix('[') else { return Some(vec![number(text)?]) };
    let words = list.strip_suffix(']')?.split(|c: char| c.is_whitespace() || c == ',' || c == ';');
    words.filter(|word| !word.is_empty()).map(number).collect()
}

/// A number as MATLAB reads it: `1d-1` is 0.1.
fn number(word: &str) -> Option<f64> {
    word.replace(['d', 'D'], "e").parse().ok()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::projector::ProjectorFile;

    const SCRIPT: &str = "% Focal length:\nfc = [ 500.5 ; 501 ];\ncc = [ 320 ; 240 ];\nalpha_c = 0.000000000000000;\n\
        kc = [ .1 ; -.05 ; .001 ; -.002 ; .01 ];\n%-- Image size:\nnx = 640;\nny = 480;\n";

    fn parse(text: &str) -> Result<ProjectorFile, String> {
        ProjectorFile::parse(Path::new("Calib_Results.m"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn plain_numbers_are_read_however_they_are_written() {
        let (kc, fc) = ("[ .1 ; -.05 ; .001 ; -.002 ; .01 ];", "[ 500.5 ; 501 ];");
        for (from, to) in [
            (kc, "[ .1 ; -.05 ; ...\n .001 ; -.002 ; .01 ];"),
            (kc, "...  of the lens\n  [ .1 -.05 ... k1 k2\n .001,-.002 , .01 ]"),
            (kc, "[ 1d-1\n -5.D-2 % k2 = -0.05\n 1e-3\n-2E-3\n .01 ];"),
            (kc, "[ .1 -.05 .001 -.002 .01 ]';"),
            (kc, "[ .1 -.05 .001 -.002 .01 ].'"),
            (kc, "zeros(5,1); kc(1) = 7; kc = [ .1 ; -.05 ; .001 ; -.002 ; .01 ];"),
            (fc, "[500.5,501]; fc_error = fc / 100; disp(fc), if nx == 5, end"),
            ("%--", "%{\nfc = [ 1 ; 1 ];\n%}\n%--"),
            ("%--", "# fc = [ 1 ; 1 ];\n%--"),
            ("kc =", "calib_name = 'it''s (50%) [; fc = 1'; s = \"kc = {1'\"; a = b'; kc ="),
            ("nx = 640;\nny = 480;\n", "width = 640; height = 480"),
            ("\n", "\r\n"),
        ] {
            let info = parse(&SCRIPT.replace(from, to)).unwrap_or_else(|error| panic!("{error}\n{to}")).camera_info;
            assert_eq!((info.K[0], info.K[4], info.K[2], info.width, info.height), (500.5, 501.0, 320.0, 640, 480));
            assert_eq!(info.D, [0.1, -0.05, 0.001, -0.002, 0.01], "{to}");
        }
        assert_eq!(parse(&SCRIPT.replace("0.000000000000000", "2.5D-1")).unwrap().camera_info.K[1], 125.125);
    }

    #[test]
    fn what_is_computed_is_refused_by_its_variable() {
        let computed = "the MATLAB script computes it";
        for (from, to, key, expected) in [
            ("kc = [", "kc = 0.01 * [", "kc", "(\'0.01 * [ .1 ; -.05 ; .001 ; -.002 ; .01 ]\'): write its numbers"),
            ("kc = [ .1", "kc = [ 1 - .9", "kc", computed),
            ("kc = [ .1", "kc = [ k1", "kc", computed),
            ("kc = [ .1", "kc = [ 1/10", "kc", computed),
            ("kc = [ .1 ;", "kc = [ [.1] ;", "kc", computed),
            ("kc = [ .1 ; -.05 ; .001 ; -.002 ; .01 ]", "kc = zeros(5,1)", "kc", computed),
            ("nx =", "kc(5) = 0.02;\nnx =", "kc", computed),
            ("nx =", "kc{1} = 0.02;\nnx =", "kc", computed),
            ("nx =", "[kc, err] = refine(kc);\nnx =", "kc", computed),
            ("nx =", "kc = -kc;\nnx =", "kc", computed),
            ("nx =", "if a, kc = 0; else kc = 1; end\nnx =", "kc", computed),
            ("kc = [ .1", "kc = [ '.1'", "kc", computed),
            ("alpha_c = 0", "alpha_c = skew/10", "alpha_c", computed),
            ("alpha_c = 0.000000000000000", "alpha_c = [0 0]", "alpha_c", "2 numbers in the MATLAB script, not 1"),
            ("fc = [ 500.5 ; 501 ]", "fc = [ 500.5 ]", "fc", "1 numbers in the MATLAB script, not 2"),
            ("fc = [ 500.5 ; 501 ]", "fc = f * [ 1 ; 1 ]", "fc", computed),
            ("nx = 640", "nx = 2 * 320", "nx", computed),
        ] {
            for text in [SCRIPT.replace(from, to), SCRIPT.replace(from, to).replace('\n', "\r\n")] {
                let error = parse(&text).unwrap_err();
                let begin = format!("Calib_Results.m: {key}: ");
                assert!(error.starts_with(&begin) && error.contains(expected), "{to}: {error}");
                assert_eq!(error.lines().count(), 1);
            }
        }
        let right = SCRIPT.replace("c = ", "c_right = ").replace("kc_right = [", "kc_right = 2 * [");
        assert!(parse(&right).unwrap_err().starts_with("Calib_Results.m: kc_right: the MATLAB script computes it"));
    }
}
