//! Coarse and finer lattices of a map's points, and where the category changes between them.

/// Points along an axis of the coarse lattice, about.
const COARSE_POINTS: usize = 25;

/// A lattice within the map: along each axis each `stride`-th point, and the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Lattice {
    /// Points of the map along each axis.
    shape: (usize, usize),
    /// Steps of the map's points along each axis.
    pub stride: (usize, usize),
}

/// Corners of a rectangle of a lattice, and thus of all that lies between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cell {
    pub first: (usize, usize),
    pub second: (usize, usize),
}

impl Cell {
    /// Places of its corners, in the order of [`bilinear`]'s weights.
    pub fn corners(&self) -> [(usize, usize); 4] {
        let ((x0, x1), (y0, y1)) = (self.first, self.second);
        [(x0, y0), (x1, y0), (x0, y1), (x1, y1)]
    }

    /// Share of each corner at a place in it.
    pub fn weights(&self, (i, j): (usize, usize)) -> [f64; 4] {
        let share = |at: usize, (low, high): (usize, usize)| {
            if high > low {
                (at - low) as f64 / (high - low) as f64
            } else {
                0.0
            }
        };
        let (x, y) = (share(i, self.first), share(j, self.second));
        [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y]
    }
}

impl Lattice {
    /// The coarse lattice of a map.
    pub fn coarse(shape: (usize, usize)) -> Self {
        let stride = |count: usize| {
            let mut stride = 1;
            while count.div_ceil(stride) > COARSE_POINTS {
                stride *= 2;
            }
            stride
        };
        Self {
            shape,
            stride: (stride(shape.0), stride(shape.1)),
        }
    }

    /// The next finer one; `None` after the last.
    pub fn finer(self) -> Option<Self> {
        let half = |stride: usize| (stride / 2).max(1);
        let stride = (half(self.stride.0), half(self.stride.1));
        (stride != self.stride).then_some(Self { stride, ..self })
    }

    /// Places of its points; the second axis counts slowest.
    pub fn points(&self) -> Vec<(usize, usize)> {
        let (along, across) = (self.lines(0), self.lines(1));
        let rows = across.iter();
        rows.flat_map(|j| along.iter().map(|i| (*i, *j))).collect()
    }

    /// Its cells; without a second axis, or with one point along an axis, they are flat.
    pub fn cells(&self) -> Vec<Cell> {
        let pairs = |lines: Vec<usize>| -> Vec<(usize, usize)> {
            match lines.as_slice() {
                [only] => vec![(*only, *only)],
                many => many.windows(2).map(|w| (w[0], w[1])).collect(),
            }
        };
        let (along, across) = (pairs(self.lines(0)), pairs(self.lines(1)));
        let rows = across.into_iter();
        rows.flat_map(|second| along.iter().map(move |&first| Cell { first, second }))
            .collect()
    }

    /// Its points in a cell of a coarser one, edges included.
    pub fn within(&self, cell: &Cell) -> Vec<(usize, usize)> {
        let between = |axis: usize, (low, high): (usize, usize)| {
            let lines = self.lines_between(axis, low, high);
            lines.collect::<Vec<_>>()
        };
        let (along, across) = (between(0, cell.first), between(1, cell.second));
        let rows = across.into_iter();
        rows.flat_map(|j| along.iter().map(move |i| (*i, j)))
            .collect()
    }

    fn lines(&self, axis: usize) -> Vec<usize> {
        let count = if axis == 0 {
            self.shape.0
        } else {
            self.shape.1
        };
        self.lines_between(axis, 0, count.saturating_sub(1))
            .collect()
    }

    fn lines_between(&self, axis: usize, low: usize, high: usize) -> impl Iterator<Item = usize> {
        let stride = if axis == 0 {
            self.stride.0
        } else {
            self.stride.1
        };
        let first = low.div_ceil(stride) * stride;
        let inner = (first..high).step_by(stride);
        inner.chain(std::iter::once(high))
    }
}

/// Indices of the points of a map of this shape, each once, in the order of a coarse lattice and ever
/// finer ones.
#[must_use]
pub fn progressive_order(shape: (usize, usize)) -> Vec<Vec<usize>> {
    let mut is_listed = vec![false; shape.0.saturating_mul(shape.1)];
    let mut passes = Vec::new();
    let mut next = Some(Lattice::coarse(shape));
    while let Some(lattice) = next {
        let places = lattice.points().into_iter();
        let all = places.map(|(i, j)| i + j * shape.0);
        let new = all.filter(|k| !std::mem::replace(&mut is_listed[*k], true));
        passes.push(new.collect());
        next = lattice.finer();
    }
    passes
}

/// Places around one, with itself.
pub(super) fn around(
    (i, j): (usize, usize),
    shape: (usize, usize),
) -> impl Iterator<Item = (usize, usize)> {
    let near =
        |at: usize, count: usize| at.saturating_sub(1)..=(at + 1).min(count.saturating_sub(1));
    near(j, shape.1).flat_map(move |j| near(i, shape.0).map(move |i| (i, j)))
}
