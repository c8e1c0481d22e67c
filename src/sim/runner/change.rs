//! Changes during a run: of the model, the drive and the longest step.

use super::pace::Pace;
use super::{Phase, Runner};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::device::Device;
use crate::sim::error::SimError;
use crate::sim::output::FastModes;
use crate::sim::step::tables::phase_tables;
use crate::sim::step::{Step, Touch};

/// Shortest limit of the step length \[s\]. Below it a run would hardly advance.
const LEAST_LIMIT: f64 = 1e-7;

impl Runner {
    /// Changes the model of the running device. Positions and velocities stay the same.
    ///
    /// # Errors
    /// [`SimError`]; nothing has changed then.
    pub fn set_model(&mut self, model: &Model) -> Result<(), SimError> {
        let device = Device::new(model)?;
        let level = device.ground_level(self.t);
        // A held state is converted to flight coordinates: these stay valid after the change.
        let mut contact = self.touch.map(|touch| touch.since);
        match self.phase {
            Phase::Held { level, since } => {
                contact = Some(since);
                self.lift(level);
            }
            Phase::Stuck { level } => self.lift(level),
            Phase::Flight => {}
        }
        self.phase = Phase::Flight;
        self.device.end_piece(&self.segment, self.t, &mut self.z);
        self.q.resize(device.flight.len(), 0.0);
        self.v.resize(device.flight.len(), 0.0);
        self.z = {
            let voltage = self.segment.shape.voltage(self.t);
            let mut at = device.flight_kinematics(self.t, voltage, &self.q, &self.v);
            device.drive_force(&mut at, self.segment.branch, &vec![0.0; device.rates.len()]);
            device.adopt_states(&self.device, &self.z, device.settled_states(&at))
        };
        let m = device.held_modes.len();
        self.r.resize(m, 0.0);
        self.dr.resize(m, 0.0);
        [self.flight_tables, self.held_tables] =
            phase_tables(&device, &self.options, [device.longest_step(); 2]);
        let interval = 1.0 / self.options.rate;
        self.flight_sampling = FastModes::sampling(&device.flight, interval);
        self.held_sampling = FastModes::sampling(&device.held_modes, interval);
        self.flight = Step::new(self.q.len(), &device.rates);
        self.held = Step::new(m, &device.rates);
        self.level = 0;
        self.delay = device.reading_delay();
        self.segment = device.piece(self.whole, self.t, &self.z);
        self.pace = Pace::of(&device, &self.options, self.t);
        self.device = device;
        self.touch = None;
        match contact {
            Some(since) if self.device.is_compliant() => {
                let (x, v) = self.proof_mass();
                if x > level {
                    self.place(level, v.min(0.0));
                }
                self.touch = Some(Touch { level, since });
                self.set_out();
            }
            Some(since) if level.is_finite() => {
                self.place(level, 0.0);
                self.land(since, level);
            }
            _ => {
                let (x, v) = self.proof_mass();
                // The ground now lies above the mass and lifts it.
                if x < level {
                    self.place(level, v.max(0.0));
                }
                self.set_out();
            }
        }
        Ok(())
    }

    /// From now on no step is longer than `longest` \[s\].
    pub fn limit_step(&mut self, longest: f64) {
        self.options.longest_step = Some(longest.max(LEAST_LIMIT));
        self.pace.limit(&self.device, &self.options);
        [self.flight_tables, self.held_tables] =
            phase_tables(&self.device, &self.options, [self.device.longest_step(); 2]);
        self.level = 0;
    }

    /// Changes the drive from now on.
    ///
    /// # Errors
    /// [`SimError`]; nothing has changed then.
    pub fn set_drive(&mut self, drive: &Waveform) -> Result<(), SimError> {
        drive.check()?;
        self.device.end_piece(&self.segment, self.t, &mut self.z);
        self.drive = drive.clone();
        self.index = self.drive.index_at(self.t);
        self.whole = self.drive.segment(self.index);
        self.segment = self.device.piece(self.whole, self.t, &self.z);
        Ok(())
    }
}
