//! A PDF of one page with filled rectangles and a line of text.
//!
//! A few hundred bytes of objects, with the font that every viewer has: less than the interface of a crate for it.

use std::fmt::Write as _;

/// Points of PDF in a millimetre.
const POINTS_IN_MM: f64 = 72.0 / 25.4;
/// Size of letters, millimetres.
const LETTER_MM: f64 = 3.0;

/// Page in the making; millimetres from its lower left corner.
pub(super) struct Page {
    size_mm: [f64; 2],
    content: String,
}

impl Page {
    pub(super) fn new(size_mm: [f64; 2]) -> Self {
        Self { size_mm, content: "0 g\n".to_owned() }
    }

    /// Black rectangle by its lower left corner and size.
    pub(super) fn rectangle(&mut self, corner_mm: [f64; 2], size_mm: [f64; 2]) {
        let [x, y, width, height] = [corner_mm[0], corner_mm[1], size_mm[0], size_mm[1]].map(points);
        // Writing to a String cannot fail.
        let _ = writeln!(self.content, "{x} {y} {width} {height} re f");
    }

    /// Text that is read upwards, by its lower left corner there. Characters outside of ASCII are left out.
    pub(super) fn text_upwards(&mut self, at_mm: [f64; 2], text: &str) {
        let plain: String = text.chars().filter(|c| c.is_ascii() && !c.is_control()).collect();
        let escaped = plain.replace('\\', "\\\\").replace('(', "\\(").replace(')', "\\)");
        let [size, x, y] = [LETTER_MM, at_mm[0], at_mm[1]].map(points);
        let _ = writeln!(self.content, "BT /F1 {size} Tf 0 1 -1 0 {x} {y} Tm ({escaped}) Tj ET");
    }

    /// Bytes of the file.
    pub(super) fn finish(self) -> Vec<u8> {
        let [width, height] = self.size_mm.map(points);
        let objects = [
            "<< /Type /Catalog /Pages 2 0 R >>".to_owned(),
            "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
            format!(
                "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Contents 4 0 R \
                 /Resources << /Font << /F1 5 0 R >> >> >>"
            ),
            format!("<< /Length {} >>\nstream\n{}endstream", self.content.len(), self.content),
            "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>".to_owned(),
        ];
        let mut file = "%PDF-1.4\n".to_owned();
        let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
        for (index, object) in objects.iter().enumerate() {
            let _ = writeln!(table, "{:010} 00000 n ", file.len());
            let _ = writeln!(file, "{} 0 obj\n{object}\nendobj", index + 1);
        }
        let start = file.len();
        let count = objects.len() + 1;
        let _ = write!(file, "{table}trailer\n<< /Size {count} /Root 1 0 R >>\nstartxref\n{start}\n%%EOF\n");
        file.into_bytes()
    }
}

/// Length in points, with three decimals (a third of a micrometre).
fn points(mm: f64) -> f64 {
    (1000.0 * mm * POINTS_IN_MM).round() / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_names_where_each_object_begins() {
        let mut page = Page::new([297.0, 210.0]);
        page.rectangle([10.0, 20.0], [25.4, 25.4]);
        page.text_upwards([5.0, 5.0], "a (b) ü\\");
        let text = String::from_utf8(page.finish()).unwrap();
        let start: usize = text.split("startxref\n").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
        let offsets = text[start..].lines().skip(3).take(5);
        for (index, line) in offsets.enumerate() {
            let offset: usize = line[..10].parse().unwrap();
            assert!(text[offset..].starts_with(&format!("{} 0 obj\n", index + 1)), "{line}");
        }
        assert!(text[start..].lines().all(|line| !line.contains(" n") || line.len() == 19), "entries have 20 bytes");
        let length: usize = text.split("/Length ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        let content = text.split("stream\n").nth(1).unwrap().strip_suffix("end").unwrap();
        assert_eq!(content.len(), length);
        assert!(content.contains("28.346 56.693 72 72 re f\n") && content.contains("(a \\(b\\) \\\\) Tj"), "{content}");
        assert!(text.contains("/MediaBox [0 0 841.89 595.276]"));
    }
}
