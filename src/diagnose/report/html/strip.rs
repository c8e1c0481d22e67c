//! The residuals along one recording, beneath its motion.

use super::FULL;
use crate::diagnose::diagnosis::{Diagnosis, Mismatch, Regime, Strip};
use crate::diagnose::report::svg::axis::Axis;
use crate::diagnose::report::svg::{Anchor, Svg, px};

/// Where the drawing begins and ends sideways \[pixels\].
const SIDES: (f64, f64) = (54.0, FULL - 14.0);
/// The motion is drawn between these heights.
const MOTION: (f64, f64) = (22.0, 62.0);
/// The residuals are drawn between these.
const RESIDUAL: (f64, f64) = (72.0, 162.0);
/// Height of the figure.
const HEIGHT: f64 = 198.0;
/// Numbers of segments nearer than this would overlap \[pixels\].
const MIN_LABEL_DISTANCE: f64 = 15.0;

/// Scales that all strips of a page share.
pub struct Scale {
    residual: Axis,
    motion: Axis,
}

impl Scale {
    /// Scales that hold all strips.
    pub fn of(d: &Diagnosis) -> Self {
        let residuals = d
            .strips
            .iter()
            .flat_map(|s| s.before.iter().chain(&s.after).copied())
            .filter(|r| *r > 0.3 * d.noise)
            .chain([0.5 * d.noise, 4.0 * d.noise]);
        let motion = d.strips.iter().flat_map(|s| s.xp.iter().copied());
        Self {
            residual: Axis::log("rms residual", "m", residuals),
            motion: Axis::linear("xp", "m", motion),
        }
    }
}

/// The figure of one strip; `marked` are its numbered segments.
pub fn figure(
    d: &Diagnosis,
    strip: &Strip,
    scale: &Scale,
    marked: &[(usize, &Mismatch)],
) -> String {
    let edges = edges(&strip.time);
    let last = edges.last().copied().unwrap_or(1.0);
    let time = Axis::exact("t", "s", edges.first().copied().unwrap_or(0.0), last);
    let x = |t: f64| SIDES.0 + time.place(t) * (SIDES.1 - SIDES.0);
    let y =
        |axis: &Axis, (top, bottom): (f64, f64), v: f64| bottom - axis.place(v) * (bottom - top);
    let label = format!("residuals along {}", strip.recording);
    let mut svg = Svg::new(FULL, HEIGHT, &label);
    svg.text("title", [2.0, 13.0], Anchor::Start, &strip.recording);
    svg.text(
        "note",
        [SIDES.1, 13.0],
        Anchor::End,
        &format!(
            "above {}, below {}",
            scale.motion.title(),
            scale.residual.title()
        ),
    );
    spots(&mut svg, marked, x);

    let points = strip.time.iter().zip(&strip.xp);
    svg.line(
        "trace",
        points.map(|(t, v)| [x(*t), y(&scale.motion, MOTION, *v)]),
    );
    for (value, label) in scale.motion.ticks(3) {
        let at = y(&scale.motion, MOTION, value);
        svg.text("tick", [SIDES.0 - 6.0, at + 4.0], Anchor::End, &label);
        svg.segment("axis", [SIDES.0 - 3.0, at], [SIDES.0, at]);
    }

    for (value, label) in scale.residual.ticks(4) {
        let at = y(&scale.residual, RESIDUAL, value);
        svg.segment("grid", [SIDES.0, at], [SIDES.1, at]);
        svg.text("tick", [SIDES.0 - 6.0, at + 4.0], Anchor::End, &label);
    }
    let height = |v: f64| y(&scale.residual, RESIDUAL, v);
    fill(&mut svg, strip, &edges, x, height);
    if !d.named.is_empty() {
        let points = strip.time.iter().zip(&strip.after);
        svg.line("over", points.map(|(t, v)| [x(*t), height(*v)]));
    }
    let proof = d
        .proof
        .iter()
        .find(|p| p.recording == strip.recording && p.held_out == strip.held_out);
    let noise = height(proof.map_or(d.noise, |p| p.noise));
    svg.segment("noise", [SIDES.0, noise], [SIDES.1, noise]);

    let (bottom, right) = (RESIDUAL.1, SIDES.1);
    svg.segment("axis", [SIDES.0, bottom], [right, bottom]);
    for (value, label) in time.ticks(9) {
        let at = x(value);
        svg.segment("axis", [at, bottom], [at, bottom + 4.0]);
        svg.text("tick", [at, bottom + 16.0], Anchor::Middle, &label);
    }
    let middle = 0.5 * (SIDES.0 + right);
    svg.text(
        "title",
        [middle, HEIGHT - 4.0],
        Anchor::Middle,
        &time.title(),
    );
    svg.finish()
}

/// Marks the numbered segments behind everything else.
fn spots(svg: &mut Svg, marked: &[(usize, &Mismatch)], x: impl Fn(f64) -> f64) {
    let mut taken: Vec<f64> = Vec::new();
    for (i, m) in marked {
        let (from, to) = (x(m.start), x(m.end));
        // A short one must still be seen.
        let width = (to - from).max(2.0);
        svg.rectangle(
            "spot",
            [from, MOTION.0 - 2.0],
            [width, RESIDUAL.1 - MOTION.0 + 2.0],
        );
        let middle = from + 0.5 * width;
        if taken
            .iter()
            .all(|t| (t - middle).abs() > MIN_LABEL_DISTANCE)
        {
            taken.push(middle);
            let number = (i + 1).to_string();
            svg.text("number", [middle, MOTION.0 + 9.0], Anchor::Middle, &number);
        }
    }
}

/// Fills from the bottom to the residual before, one path for each run of bins of one
/// regime.
fn fill(
    svg: &mut Svg,
    strip: &Strip,
    edges: &[f64],
    x: impl Fn(f64) -> f64,
    height: impl Fn(f64) -> f64,
) {
    let count = strip
        .time
        .len()
        .min(strip.before.len())
        .min(strip.regime.len());
    let mut at = 0;
    while at < count {
        if !strip.before[at].is_finite() {
            at += 1;
            continue;
        }
        let regime = strip.regime[at];
        let bottom = px(RESIDUAL.1);
        let mut path = format!("M{} {bottom}", px(x(edges[at])));
        while at < count && strip.regime[at] == regime && strip.before[at].is_finite() {
            path.push_str(&format!(
                "V{}H{}",
                px(height(strip.before[at])),
                px(x(edges[at + 1]))
            ));
            at += 1;
        }
        path.push_str(&format!("V{bottom}Z"));
        let class = Regime::ALL.iter().position(|r| *r == regime).unwrap_or(0);
        svg.path(&format!("r{class}"), &path);
    }
}

/// Edges of bins with the middles given, one more than these.
fn edges(middles: &[f64]) -> Vec<f64> {
    let n = middles.len();
    if n == 0 {
        return Vec::new();
    }
    let half = |i: usize| {
        let j = i.clamp(1, n.max(2) - 1);
        if n > 1 {
            0.5 * (middles[j] - middles[j - 1])
        } else {
            0.5e-3
        }
    };
    let mut edges: Vec<f64> = (0..n).map(|i| middles[i] - half(i)).collect();
    edges.push(middles[n - 1] + half(n - 1));
    edges
}

#[cfg(test)]
mod tests {
    use super::edges;

    #[test]
    fn bins_touch() {
        assert_eq!(edges(&[1.0, 3.0, 5.0]), [0.0, 2.0, 4.0, 6.0]);
        assert_eq!(edges(&[1.0]).len(), 2);
        assert!(edges(&[]).is_empty());
    }
}
