//! The device in physical coordinates, from the mode table.
//!
//! Units: um, ms, mg, hence uN for forces and uN/um = N/m for stiffness. All numbers of
//! the state are then between 1e-3 and 1e3, and one absolute tolerance suits them.

/// State `[xc, xp, xc', xp']` in um and um/ms.
pub type State = [f64; 4];

/// One row of the mode table: Hz, damping ratio, shapes in kg^-1/2.
#[derive(Debug, Clone, Copy)]
pub struct ModeRow {
    pub hz: f64,
    pub zeta: f64,
    pub phi_c: f64,
    pub phi_p: f64,
}

/// Everything the hybrid system needs, in the units above.
#[derive(Debug, Clone, Copy)]
pub struct Device {
    pub m: [[f64; 2]; 2],
    pub b: [[f64; 2]; 2],
    pub k: [[f64; 2]; 2],
    /// uN per unit of the piezo polynomial.
    pub eta: f64,
    /// uN um^2 ms.
    pub cs: f64,
    /// um.
    pub gp: f64,
    /// um.
    pub dp: f64,
    /// uN/ms.
    pub ca: f64,
    /// uN.
    pub ca0: f64,
    pub alpha: f64,
}

impl Device {
    /// The values that reproduce the paper's simulated results.
    pub fn paper() -> Self {
        let modes = table(0.0262, 0.0257);
        Self::from_modes(modes, 0.3819, 1.747, 70.0, 58.0, 1.7e-3, 0.02743, 0.378)
    }

    /// The values as printed; eta is 3.819e-7 N scaled from 16.5 um of static motion to
    /// 14.1 um and rounded as in the preset.
    pub fn paper_as_printed() -> Self {
        let modes = table(0.02, 0.02);
        Self::from_modes(modes, 0.32635, 1.747, 82.0, 70.0, 1.7e-3, 0.2743, 0.378)
    }

    /// The paper's device with other damping ratios.
    pub fn damped(self, zeta1: f64, zeta2: f64) -> Self {
        let (m, b, k) = matrices(table(zeta1, zeta2));
        Self { m, b, k, ..self }
    }

    #[allow(clippy::too_many_arguments)] // a row of a table, read once
    fn from_modes(
        modes: [ModeRow; 2],
        eta: f64,
        cs: f64,
        gp: f64,
        dp: f64,
        ca: f64,
        ca0: f64,
        alpha: f64,
    ) -> Self {
        let (m, b, k) = matrices(modes);
        Self {
            m,
            b,
            k,
            eta,
            cs,
            gp,
            dp,
            ca,
            ca0,
            alpha,
        }
    }

    /// Accelerations in flight with force `drive` [uN] on the cantilever.
    pub fn flight(&self, s: &State, drive: f64) -> [f64; 2] {
        let gap = s[1] + self.gp;
        let film = -self.cs * s[3] / (gap * gap * gap);
        let load = |row: usize| {
            self.b[row][0] * s[2]
                + self.b[row][1] * s[3]
                + self.k[row][0] * s[0]
                + self.k[row][1] * s[1]
        };
        let (fc, fp) = (drive - load(0), film - load(1));
        let m = &self.m;
        let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        [
            (m[1][1] * fc - m[0][1] * fp) / det,
            (m[0][0] * fp - m[1][0] * fc) / det,
        ]
    }

    /// Acceleration of the cantilever with `xp'' = 0`: the first row of the equation.
    pub fn held(&self, s: &State, drive: f64) -> f64 {
        let load =
            self.b[0][0] * s[2] + self.b[0][1] * s[3] + self.k[0][0] * s[0] + self.k[0][1] * s[1];
        (drive - load) / self.m[0][0]
    }

    /// Eq (13): the second row, solved for the force that the ground need not exert.
    pub fn pull_off(&self, s: &State, drive: f64) -> f64 {
        -(self.m[1][0] * self.held(s, drive)
            + self.b[1][0] * s[2]
            + self.k[1][0] * s[0]
            + self.k[1][1] * s[1]
            + self.b[1][1] * s[3])
    }

    /// Rate of change of [`Self::pull_off`] while held (`xp' = 0`), for `drive' = rate`.
    pub fn pull_off_rate(&self, s: &State, drive: f64, rate: f64) -> f64 {
        let acceleration = self.held(s, drive);
        let jerk = (rate - self.b[0][0] * acceleration - self.k[0][0] * s[2]) / self.m[0][0];
        -(self.m[1][0] * jerk + self.b[1][0] * acceleration + self.k[1][0] * s[2])
    }

    /// State after an impulse on the proof mass alone that leaves it with velocity `to`:
    /// the first row of `M dx' = [0, J]` says what the cantilever does.
    pub fn impulse(&self, s: &State, to: f64) -> State {
        let change = to - s[3];
        [s[0], s[1], s[2] - self.m[0][1] / self.m[0][0] * change, to]
    }

    /// Kinetic and elastic energy [uN um].
    pub fn energy(&self, s: &State) -> f64 {
        let form = |a: &[[f64; 2]; 2], x: f64, y: f64| {
            0.5 * (a[0][0] * x * x + (a[0][1] + a[1][0]) * x * y + a[1][1] * y * y)
        };
        form(&self.m, s[2], s[3]) + form(&self.k, s[0], s[1])
    }
}

/// The two modes of the paper.
fn table(zeta1: f64, zeta2: f64) -> [ModeRow; 2] {
    [
        ModeRow {
            hz: 623.0,
            zeta: zeta1,
            phi_c: 13381.005,
            phi_p: 50145.332,
        },
        ModeRow {
            hz: 6424.0,
            zeta: zeta2,
            phi_c: 74486.762,
            phi_p: -12923.177,
        },
    ]
}

type Matrix = [[f64; 2]; 2];

/// `M = Phi^-T Phi^-1`, `B = Phi^-T diag(2 zeta w) Phi^-1`, `K = Phi^-T diag(w^2) Phi^-1`,
/// written out: with `Phi^-1 = [[a, b], [c, d]]` each is `d1 r1^T r1 + d2 r2^T r2`.
fn matrices(modes: [ModeRow; 2]) -> (Matrix, Matrix, Matrix) {
    // kg^-1/2 to mg^-1/2.
    let shape = modes.map(|r| (r.phi_c * 1e-3, r.phi_p * 1e-3));
    let omega = modes.map(|r| std::f64::consts::TAU * r.hz * 1e-3);
    let det = shape[0].0 * shape[1].1 - shape[1].0 * shape[0].1;
    let rows = [
        [shape[1].1 / det, -shape[1].0 / det],
        [-shape[0].1 / det, shape[0].0 / det],
    ];
    let sum = |weight: [f64; 2]| -> Matrix {
        let entry = |i: usize, j: usize| -> f64 {
            (0..2).map(|n| weight[n] * rows[n][i] * rows[n][j]).sum()
        };
        [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
    };
    (
        sum([1.0, 1.0]),
        sum([
            2.0 * modes[0].zeta * omega[0],
            2.0 * modes[1].zeta * omega[1],
        ]),
        sum([omega[0] * omega[0], omega[1] * omega[1]]),
    )
}
