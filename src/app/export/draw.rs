//! Charts onto a plotters surface, vector or pixels alike.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::charts::Chart;
use crate::sim::EventKind;

/// Draws the charts one below the other.
///
/// # Errors
/// What the surface says.
pub fn all<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    charts: &[Chart],
) -> Result<(), String> {
    area.fill(&WHITE).map_err(|error| error.to_string())?;
    for (part, chart) in area.split_evenly((charts.len(), 1)).iter().zip(charts) {
        one(part, chart).map_err(|error| error.to_string())?;
    }
    Ok(())
}

fn one<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    chart: &Chart,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let (y0, y1) = chart.y_range;
    let mut context = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(78)
        .build_cartesian_2d(chart.x_range.0..chart.x_range.1, y0..y1)?;
    context.draw_series(chart.shaded.iter().map(|&(from, to)| {
        Rectangle::new([(from, y0), (to, y1)], RGBColor(240, 228, 190).filled())
    }))?;
    context
        .configure_mesh()
        .x_desc(&chart.x_label)
        .y_desc(&chart.y_label)
        .axis_desc_style(("sans-serif", 18))
        .label_style(("sans-serif", 15))
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(222, 222, 222))
        .draw()?;
    if let Some((level, name)) = chart.level {
        context
            .draw_series(LineSeries::new(
                [(chart.x_range.0, level), (chart.x_range.1, level)],
                RGBColor(110, 80, 40).stroke_width(1),
            ))?
            .label(name)
            .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], RGBColor(110, 80, 40)));
    }
    for line in &chart.lines {
        let color = RGBColor(line.color.0, line.color.1, line.color.2);
        let whole = line.points.split(|point| !point.1.is_finite());
        for (i, points) in whole.filter(|points| !points.is_empty()).enumerate() {
            let series = context.draw_series(LineSeries::new(
                points.iter().copied(),
                color.stroke_width(1),
            ))?;
            if i == 0 {
                series.label(&line.name).legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2))
                });
            }
        }
    }
    context.draw_series(chart.marks.iter().map(|&(x, y, kind)| {
        let color = match kind {
            EventKind::Impact => RGBColor(213, 94, 0),
            EventKind::Stick => RGBColor(230, 159, 0),
            EventKind::Release | EventKind::DriveStep => RGBColor(0, 158, 115),
        };
        Circle::new((x, y), 3, color.filled())
    }))?;
    context
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .label_font(("sans-serif", 15))
        .draw()
}
