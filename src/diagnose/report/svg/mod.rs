//! Figures as SVG text that stands inside a page.
//!
//! Colours are classes that the page's style sheet fills in, so that a figure follows
//! the reader's light or dark scheme and the printer; places are fractions of a pixel.
//! (The drawing crate that exports the window's plots writes fixed colours and whole
//! pixels.)

pub(crate) mod axis;
pub(crate) mod plot;

use std::fmt::Write;

/// Where text stands against its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// Ends there.
    End,
}

/// A figure that is being written. Places are pixels from the left upper corner.
#[derive(Debug)]
pub struct Svg {
    text: String,
}

impl Svg {
    /// An empty figure; `label` says to a reader who does not see it what it shows.
    pub fn new(width: f64, height: f64, label: &str) -> Self {
        let mut text = String::new();
        let (w, h) = (px(width), px(height));
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "<svg viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" aria-label=\"{}\">",
            escape(label)
        );
        Self { text }
    }

    /// A straight line.
    pub fn segment(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        let _ = write!(
            self.text,
            "<path class=\"{class}\" d=\"M{} {}L{} {}\"/>",
            px(from[0]),
            px(from[1]),
            px(to[0]),
            px(to[1])
        );
    }

    /// A line through points; it breaks where one is not finite.
    pub fn line(&mut self, class: &str, points: impl IntoIterator<Item = [f64; 2]>) {
        let mut path = String::new();
        let mut pen_down = false;
        for [x, y] in points {
            if x.is_finite() && y.is_finite() {
                let command = if pen_down { 'L' } else { 'M' };
                let _ = write!(path, "{command}{} {}", px(x), px(y));
                pen_down = true;
            } else {
                pen_down = false;
            }
        }
        self.path(class, &path);
    }

    /// A path as SVG writes it; nothing if it is empty.
    pub fn path(&mut self, class: &str, path: &str) {
        if !path.is_empty() {
            let _ = write!(self.text, "<path class=\"{class}\" d=\"{path}\"/>");
        }
    }

    /// A filled rectangle.
    pub fn rectangle(&mut self, class: &str, from: [f64; 2], size: [f64; 2]) {
        let _ = write!(
            self.text,
            "<rect class=\"{class}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
            px(from[0]),
            px(from[1]),
            px(size[0].max(0.0)),
            px(size[1].max(0.0))
        );
    }

    /// A dot.
    pub fn dot(&mut self, class: &str, at: [f64; 2], radius: f64) {
        let _ = write!(
            self.text,
            "<circle class=\"{class}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>",
            px(at[0]),
            px(at[1]),
            px(radius)
        );
    }

    /// A text on one line, at its base line.
    pub fn text(&mut self, class: &str, at: [f64; 2], anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let _ = write!(
            self.text,
            "<text class=\"{class}\" x=\"{}\" y=\"{}\" text-anchor=\"{anchor}\">{}</text>",
            px(at[0]),
            px(at[1]),
            escape(text)
        );
    }

    /// The whole figure.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// A length in tenths of a pixel. What is not finite becomes 0: a figure has no NaN.
pub fn px(value: f64) -> String {
    let value = if value.is_finite() { value } else { 0.0 };
    let text = format!("{value:.1}");
    match text.strip_suffix(".0") {
        Some("-0") => "0".to_owned(),
        Some(whole) => whole.to_owned(),
        None => text,
    }
}

/// The text as it may stand in HTML and SVG, in elements and attributes. Characters that
/// XML forbids become spaces.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::svg::*;

    #[test]
    fn nothing_that_is_not_a_number_gets_into_a_figure() {
        let mut svg = Svg::new(10.0, 10.0, "a <b> & \"c\"");
        svg.line("l", [[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0], [3.0, 4.04]]);
        svg.dot("d", [f64::INFINITY, 1.0], 2.0);
        let text = svg.finish();
        assert!(text.contains("d=\"M0 1M2 3L3 4\""), "{text}");
        assert!(text.contains("a &lt;b&gt; &amp; &quot;c&quot;"), "{text}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }
}
