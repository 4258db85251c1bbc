//! Minimal SVG writer for the plots. Texts are escaped, numbers finite and short.

use std::fmt::Write as _;

/// Font stack.
pub(super) const FONTS: &str = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif";

/// Alignment of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// SVG builder. Attributes (`stroke`, `fill`, …) are verbatim text.
pub(super) struct Svg {
    text: String,
}

impl Svg {
    /// Creates an empty drawing of a size; `title` is for screen readers.
    pub(super) fn new([width, height]: [f64; 2], title: &str) -> Self {
        let title = escaped(title);
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
             aria-label=\"{title}\" font-family=\"{FONTS}\" font-size=\"12\">\n"
        );
        Self { text }
    }

    pub(super) fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], attributes: &str) {
        let [x, y, width, height] = [x, y, width.max(0.0), height.max(0.0)].map(short);
        self.element(&format!("rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" {attributes}"));
    }

    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], attributes: &str) {
        let ([x1, y1], [x2, y2]) = (from.map(short), to.map(short));
        self.element(&format!("line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {attributes}"));
    }

    pub(super) fn circle(&mut self, center: [f64; 2], radius: f64, attributes: &str) {
        let [x, y] = center.map(short);
        self.element(&format!("circle cx=\"{x}\" cy=\"{y}\" r=\"{}\" {attributes}", short(radius)));
    }

    /// Polyline.
    pub(super) fn path(&mut self, places: &[[f64; 2]], attributes: &str) {
        let mut path = String::new();
        for (index, place) in places.iter().enumerate() {
            let [x, y] = place.map(short);
            let command = if index == 0 { 'M' } else { 'L' };
            // Writing to a String cannot fail.
            let _ = write!(path, "{command}{x} {y}");
        }
        self.element(&format!("path d=\"{path}\" {attributes}"));
    }

    /// Dots as one shape; their size is the stroke's width.
    pub(super) fn dots(&mut self, places: impl Iterator<Item = [f64; 2]>, attributes: &str) {
        let path: String = places.map(|place| place.map(short)).map(|[x, y]| format!("M{x} {y}h.01")).collect();
        self.element(&format!("path d=\"{path}\" stroke-linecap=\"round\" fill=\"none\" {attributes}"));
    }

    /// Arrow; its head is at most 45 % of it.
    pub(super) fn arrow(&mut self, from: [f64; 2], to: [f64; 2], attributes: &str) {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        if length < 0.4 || !length.is_finite() {
            return;
        }
        let head = (0.45 * length).min(5.0) / length;
        let wing = |side: f64| {
            let [x, y] = along;
            [to[0] - head * (x + 0.55 * side * y), to[1] - head * (y - 0.55 * side * x)]
        };
        self.line(from, to, attributes);
        self.path(&[wing(1.0), to, wing(-1.0)], &format!("fill=\"none\" {attributes}"));
    }

    pub(super) fn text(&mut self, place: [f64; 2], anchor: Anchor, text: &str, attributes: &str) {
        let [x, y] = place.map(short);
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escaped(text);
        let _ = writeln!(self.text, "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" {attributes}>{text}</text>");
    }

    /// Text rotated to read upwards.
    pub(super) fn text_upwards(&mut self, place: [f64; 2], text: &str, attributes: &str) {
        let [x, y] = place.map(short);
        self.text(place, Anchor::Middle, text, &format!("transform=\"rotate(-90 {x} {y})\" {attributes}"));
    }

    /// Finished drawing.
    pub(super) fn finish(mut self) -> String {
        self.text += "</svg>\n";
        self.text
    }

    fn element(&mut self, contents: &str) {
        let _ = writeln!(self.text, "<{contents}/>");
    }
}

/// Rounds to two decimals; values that are not finite become 0.
fn short(value: f64) -> f64 {
    if value.is_finite() {
        // Adding zero removes the sign of a negative zero.
        (value.clamp(-1e6, 1e6) * 100.0).round() / 100.0 + 0.0
    } else {
        0.0
    }
}

/// Escapes a text for HTML and SVG, inside and outside of quotes.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            _ if character.is_control() && character != '\n' => escaped.push(' '),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped_and_numbers_are_finite() {
        let mut svg = Svg::new([10.0, 20.0], "a \"title\"");
        svg.text([1.0, f64::NAN], Anchor::Middle, "<b> & 'c'\u{7}", "");
        svg.line([f64::INFINITY, -0.0], [1.0 / 3.0, 1e300], "");
        let text = svg.finish();
        assert!(text.contains("aria-label=\"a &quot;title&quot;\""), "{text}");
        assert!(text.contains(">&lt;b&gt; &amp; &#39;c&#39; </text>"), "{text}");
        assert!(text.contains("x1=\"0\" y1=\"0\" x2=\"0.33\" y2=\"1000000\""), "{text}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }
}
