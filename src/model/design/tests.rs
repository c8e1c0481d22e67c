//! Designs against closed forms and the paper's device.

use std::f64::consts::TAU;

use crate::model::design::*;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::unit::Coordinate;
use crate::sim::{Options, simulate};

fn close(found: f64, expected: f64, share: f64, what: &str) {
    assert!(
        (found / expected - 1.0).abs() <= share,
        "{what}: {found} for {expected}"
    );
}

/// The written preset is read again as the same.
fn comes_back(made: &Designed) {
    let text = made.preset.to_toml();
    let again = Preset::parse("own.toml", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(again, made.preset, "{text}");
    for (id, (low, high)) in &made.preset.ranges {
        assert!(low < high, "{id:?}");
    }
}

const PAPER: &str = "L=750um,EI=1.139e-12,m=3.519e-7,mass=3.495e-10kg,mass_size=150x100x10um,modes=3,ground=58um,film=12um,zeta=0.0262/0.0257";

#[test]
fn a_bare_cantilever_has_the_roots_of_the_textbook() {
    // cos(z) cosh(z) = -1; R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979.
    let roots = [
        1.875_104_068_7,
        4.694_091_133,
        7.854_757_438_2,
        10.995_540_734_9,
    ];
    let beam = BeamDesign::new(
        2.0,
        Section::given(3.0, 5.0).unwrap(),
        EndMass::default(),
        20,
    );
    let modes = beam_modes(&beam).unwrap();
    for (mode, root) in modes.iter().zip(roots) {
        close(mode.wave_number, root, 1e-9, "root");
        let frequency = root * root * (3.0f64 / 5.0).sqrt() / 4.0 / TAU;
        close(mode.frequency, frequency, 1e-9, "frequency");
    }
    // Every mode of a bare cantilever has w(L) = 2 / sqrt(m L).
    for (i, mode) in modes.iter().enumerate() {
        close(
            mode.end.abs(),
            2.0 / 10f64.sqrt(),
            1e-8,
            &format!("end of mode {i}"),
        );
        let high = (i as f64 + 0.5) * std::f64::consts::PI;
        assert!(
            (mode.wave_number - high).abs() < 0.31,
            "{i}: {}",
            mode.wave_number
        );
    }
}

#[test]
fn an_end_mass_satisfies_its_transcendental_equation() {
    // 1 + cos cosh + (M / m L) z (cos sinh - sin cosh) = 0 for a point mass.
    for ratio in [1e-3, 0.5, 1.0, 30.0, 1e5] {
        let end = EndMass {
            mass: ratio * 6.0,
            ..EndMass::default()
        };
        let beam = BeamDesign::new(3.0, Section::given(1.0, 2.0).unwrap(), end, 4);
        for mode in beam_modes(&beam).unwrap() {
            let z = mode.wave_number;
            let value = 1.0 / z.cosh() + z.cos() + ratio * z * (z.cos() * z.tanh() - z.sin());
            assert!(
                value.abs() < 1e-8 * (1.0 + ratio * z),
                "{ratio}: {z} leaves {value}"
            );
        }
    }
    // A very heavy mass on a light beam: k = 3 EI / L^3.
    let end = EndMass {
        mass: 1e6,
        ..EndMass::default()
    };
    let beam = BeamDesign::new(0.5, Section::given(7.0, 0.01).unwrap(), end, 1);
    let mode = beam_modes(&beam).unwrap()[0];
    close(
        mode.frequency,
        (3.0 * 7.0 / 0.125 / 1e6f64).sqrt() / TAU,
        1e-6,
        "heavy mass",
    );
    close(mode.end, 1e-3, 1e-6, "its shape");
}

#[test]
fn the_papers_beam_has_the_papers_modes() {
    let made = describe(DesignKind::Beam, PAPER).unwrap();
    let model = &made.preset.model;
    let expected = [
        (623.0, 13381.005, 50145.332),
        (6424.0, 74486.762, -12923.177),
        (19175.0, 63144.79, 2944.80),
    ];
    assert_eq!(model.modes.len(), 3);
    for (mode, (frequency, phi_c, phi_p)) in model.modes.iter().zip(expected) {
        println!("{} {} {}", mode.frequency, mode.phi_c, mode.phi_p);
        close(mode.frequency, frequency, 2e-4, "frequency");
        close(mode.phi_c, phi_c, 5e-4, "phi_c");
        close(mode.phi_p, phi_p, 5e-4, "phi_p");
    }
    close(model.parameters[ParameterId::Cs], 1.5e-21, 0.1, "Cs");
    close(model.parameters[ParameterId::Gp], 70e-6, 1e-9, "gp");
    comes_back(&made);
    // Orthogonality of two modes at the points that are not read is in the mass: with all of them,
    // the static compliance at the end is that of the beam under a force.
    let many = PAPER.replace("modes=3", "modes=25");
    let modes = describe(DesignKind::Beam, &many)
        .unwrap()
        .preset
        .model
        .modes;
    let compliance: f64 = modes.iter().map(|m| (m.phi_p / m.omega()).powi(2)).sum();
    // A force at the mass's centre, d beyond the end: L^3/3 + L^2 d + L d^2, over EI.
    let (l, d) = (750e-6f64, 75e-6f64);
    let expected = (l.powi(3) / 3.0 + l * l * d + l * d * d) / 1.139e-12;
    close(compliance, expected, 1e-4, "compliance");
}

#[test]
fn layers_bend_as_a_bimetal() {
    // Timoshenko's bimetal with a free strain d31 V / t in the upper layer.
    let layers = "layers=steel:0.3mm+PZT-5A:0.2mm";
    let text = format!("L=30mm,W=6mm,{layers},modes=20,V=10V");
    let made = describe(DesignKind::Beam, &text).unwrap();
    comes_back(&made);
    let (e1, t1, e2, t2) = (200e9f64, 0.3e-3f64, 61e9f64, 0.2e-3f64);
    let strain = -171e-12 / t2;
    let (m, n) = (t2 / t1, e2 / e1);
    let h = t1 + t2;
    let curvature = -6.0 * strain * (1.0 + m).powi(2)
        / (h * (3.0 * (1.0 + m).powi(2) + (1.0 + m * n) * (m * m + 1.0 / (m * n))));
    let expected = 0.5 * curvature * 30e-3f64.powi(2);
    let model = &made.preset.model;
    let per_volt = model.structure().static_gain().unwrap()
        * model.parameters[ParameterId::Eta]
        * model
            .piezo
            .unwrap()
            .gain(1.0, crate::model::piezo::Branch::Rising);
    assert!(
        expected > 0.0,
        "a contracting upper layer bends the tip upward"
    );
    close(per_volt, expected, 2e-3, "tip per volt");
    // The same layers the other way up, poled the other way round, bend downward.
    let flipped = text.replace(layers, "layers=PZT-5A:0.2mm+steel:0.3mm");
    let down = describe(DesignKind::Beam, &flipped).unwrap().preset.model;
    assert!(down.piezo.unwrap().rising[1] < 0.0);
    // A symmetric bimorph poled oppositely bends twice what one of its layers does.
    let one = "L=30mm,W=6mm,layers=PZT-5A(d31=0):0.2mm+PZT-5A:0.2mm,modes=2";
    let both = "L=30mm,W=6mm,layers=PZT-5A(d31=171pm/V):0.2mm+PZT-5A:0.2mm,modes=2";
    let eta = |t: &str| {
        describe(DesignKind::Beam, t)
            .unwrap()
            .preset
            .model
            .parameters[ParameterId::Eta]
    };
    close(eta(both), 2.0 * eta(one), 1e-9, "bimorph");
    let silent = describe(DesignKind::Beam, &text.replace("PZT-5A", "PZT-5A(d31=0)")).unwrap();
    assert!(silent.preset.model.piezo.is_none());
    assert!(
        silent.notes.iter().any(|n| n.contains("no drive")),
        "{:?}",
        silent.notes
    );
}

#[test]
fn a_mass_on_a_spring_rings_at_its_frequency_at_every_scale() {
    for (text, f1) in [
        (
            "m=0.2016kg,k=14.92N/m,zeta=0.002,x0=0.1m",
            (14.92f64 / 0.2016).sqrt() / std::f64::consts::TAU,
        ),
        ("m=1ng,f=100kHz,zeta=0.01,x0=10nm", 1e5),
        ("m=50kg,k=20kN/m,zeta=0.05,x0=2cm,ground=30cm", 3.183099),
    ] {
        let made = describe(DesignKind::Spring, text).unwrap();
        comes_back(&made);
        let model = &made.preset.model;
        close(model.parameters[ParameterId::F1], f1, 1e-5, text);
        let (low, high) = made.preset.range(ParameterId::F1);
        assert!(low < f1 && f1 < high && high < 10.0 * f1, "{text}");
        let x0 = model.parameters[ParameterId::X0];
        let (low, high) = made.preset.range(ParameterId::X0);
        assert!(
            low < x0 && x0 < high && high < 100.0 * x0,
            "{text}: {low} {high}"
        );
        let drive = Waveform::Rest;
        let options = Options {
            rate: 200.0 * f1,
            ..Options::default()
        };
        let trace = simulate(model, &drive, 10.0 / f1, &options).unwrap();
        let crossings = trace
            .proof_mass
            .windows(2)
            .filter(|w| w[0] > 0.0 && w[1] <= 0.0)
            .count();
        assert_eq!(crossings, 10, "{text}");
    }
}

#[test]
fn a_pendulum_has_the_period_of_the_elliptic_integral() {
    let made = describe(
        DesignKind::Pendulum,
        "L=0.5m,angle=60deg,zeta=0,m=0.2kg,name=swing",
    )
    .unwrap();
    comes_back(&made);
    let model = &made.preset.model;
    assert_eq!(
        (model.coordinate, model.name.as_str()),
        (Coordinate::Angle, "swing")
    );
    close(
        model.parameters[ParameterId::X0],
        60f64.to_radians(),
        1e-12,
        "angle",
    );
    close(model.proof_mass, 0.05, 1e-12, "inertia");
    // T = T0 2/pi K(sin(a/2)), by the arithmetic-geometric mean.
    let (mut a, mut g) = (1.0f64, (30f64.to_radians()).cos());
    for _ in 0..6 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    let period = TAU * (0.5f64 / 9.80665).sqrt() / a;
    let rate = 2000.0 / period;
    let options = Options {
        rate,
        ..Options::default()
    };
    let trace = simulate(model, &Waveform::Rest, 5.2 * period, &options).unwrap();
    let x = &trace.proof_mass;
    let downs: Vec<f64> = (1..x.len())
        .filter(|&i| x[i - 1] > 0.0 && x[i] <= 0.0)
        .map(|i| (i as f64 - x[i] / (x[i] - x[i - 1])) / rate)
        .collect();
    close(
        (downs[4] - downs[0]) / 4.0,
        period,
        1e-5,
        "period at 60 degrees",
    );
    // A rod about its end: T = 2 pi sqrt(2 l / 3 g).
    let rod = describe(DesignKind::Pendulum, "L=0.5m,m=3kg,inertia=1.0,angle=1deg").unwrap();
    close(
        rod.preset.model.parameters[ParameterId::F1],
        (3.0 * 9.80665 * 0.5f64).sqrt() / TAU,
        1e-12,
        "rod",
    );
    let said = describe(DesignKind::Pendulum, "L=1m,m=1kg,inertia=0.5")
        .unwrap_err()
        .to_string();
    assert!(said.contains("at least"), "{said}");
}

#[test]
fn a_free_mass_falls_and_bounces() {
    let made = describe(DesignKind::Free, "m=5g,x0=25cm,ground=5cm,alpha=0.7").unwrap();
    comes_back(&made);
    let trace = simulate(
        &made.preset.model,
        &Waveform::Rest,
        1.0,
        &Options::default(),
    )
    .unwrap();
    let first = trace
        .events
        .iter()
        .find(|e| e.kind == crate::sim::EventKind::Impact)
        .unwrap();
    close(
        first.time,
        (2.0 * 0.3 / 9.80665f64).sqrt(),
        1e-6,
        "first bounce",
    );
    assert!(made.notes.iter().any(|n| n.contains("standard gravity")));
    let free = describe(DesignKind::Free, "m=1kg,g=1.62m/s^2,v0=3m/s").unwrap();
    comes_back(&free);
    assert!(!free.preset.model.has_ground && free.preset.known.is_empty());
}

#[test]
fn tables_of_modes_are_read_in_both_forms() {
    let csv = "# measured\nf [kHz],zeta [%],phi_c,phi_p\n6.424,2.57,74486.762,-12923.177\n0.623,2.62,13381.005,50145.332\n";
    let toml = "[[mode]]\nfrequency = 623.0\nzeta = 0.0262\nphi_c = 13381.005\nphi_p = 50145.332\n[[mode]]\nf = 6424.0\nQ = 19.455252918287938\nphi_c = 74486.762\nphi_p = -12923.177\n";
    let one = ModesTable::parse("a.csv", csv).unwrap();
    let two = ModesTable::parse("a.toml", toml).unwrap();
    for (a, b) in one.modes.iter().zip(&two.modes) {
        close(a.frequency, b.frequency, 1e-12, "frequency");
        close(a.zeta, b.zeta, 1e-9, "zeta");
        assert_eq!((a.phi_c, a.phi_p), (b.phi_c, b.phi_p));
    }
    let made = describe(
        DesignKind::Modes("a.csv", csv),
        "force=0.38uN/V,ground=58um,V=8V",
    )
    .unwrap();
    comes_back(&made);
    let paper = Preset::default().model;
    let model = &made.preset.model;
    assert_eq!(model.structure().modes.len(), 2);
    close(
        model.structure().mobility(),
        paper.structure().mobility(),
        1e-9,
        "mobility",
    );
    // A shape of any scale with its modal mass is the same mode.
    let scaled = "f,Q,phi_p,modal_mass [ng]\n10,50,1,400\n";
    let mode = ModesTable::parse("b.csv", scaled).unwrap().modes[0];
    close(mode.phi_p, 1.0 / 4e-10f64.sqrt(), 1e-12, "modal mass");
    for (file, text, place, part) in [
        (
            "a.csv",
            "f,zeta,phi_p\n1,2\n",
            "line 2, column 3",
            "2 cells for 3",
        ),
        (
            "a.csv",
            "f,zeta,phi_p\n1,x,3\n",
            "line 2, column 2",
            "not a number",
        ),
        ("a.csv", "f,zeta,phi\n", "line 1, column 3", "no column"),
        ("a.csv", "f [s],zeta,phi_p\n", "line 1, column 1", "no unit"),
        ("a.csv", "f,f,phi_p\n", "line 1, column 2", "twice"),
        ("a.csv", "", "line 1", "no table"),
        ("a.csv", "f,zeta\n1,2\n", "line 2", "no phi_p"),
        (
            "a.toml",
            "[[mode]]\nf = 1.0\nphi_q = 2.0\n",
            "line 3",
            "unknown field",
        ),
        (
            "a.toml",
            "[[mode]]\nf = 1.0\nphi_p = 2.0\n[[mode]]\nphi_p = 1.0\n",
            "line 4",
            "no frequency",
        ),
    ] {
        let said = ModesTable::parse(file, text).unwrap_err().to_string();
        assert!(
            said.contains(place) && said.contains(part),
            "{text:?}: {said}"
        );
    }
}

#[test]
fn faults_of_a_text_name_the_key_and_the_remedy() {
    for (kind, text, parts) in [
        (
            DesignKind::Beam,
            "L=750us,EI=1,m=1",
            ["L:", "write it in m"],
        ),
        (DesignKind::Beam, "L=750um", ["section", "layers="]),
        (
            DesignKind::Beam,
            "L=750um,W=100um,layers=Sil:5um",
            ["\"Sil\"", "there are Si,"],
        ),
        (
            DesignKind::Beam,
            "L=750um,layers=Si:5um",
            ["W: is missing", "W=100um"],
        ),
        (
            DesignKind::Beam,
            "L=750um,W=1um,layers=Si",
            ["Si", "MATERIAL:THICKNESS"],
        ),
        (
            DesignKind::Beam,
            "L=750um,EI=1,m=1,film=1um",
            ["film", "ground=58um"],
        ),
        (DesignKind::Beam, "L=1,L=2", ["L=2", "twice"]),
        (DesignKind::Beam, "length=1", ["length", "there are L, W"]),
        (
            DesignKind::Beam,
            "L=0,75mm,EI=1,m=1",
            ["75mm", "decimals with a point"],
        ),
        (DesignKind::Beam, "L=-1m,EI=1,m=1", ["L:", "above 0"]),
        (
            DesignKind::Beam,
            "L=1m,EI=1,m=1,modes=0",
            ["modes", "1 to 32"],
        ),
        (
            DesignKind::Beam,
            "L=1m,EI=1,m=1,mass_size=1x2um",
            ["mass_size", "3 are needed"],
        ),
        (DesignKind::Spring, "m=1g", ["k:", "k or f"]),
        (DesignKind::Spring, "m=1g,k=1N", ["k:", "N/m"]),
        (DesignKind::Free, "x0=1m", ["m: is missing", "m=5g"]),
        (
            DesignKind::Spring,
            "m=1g,k=1,ground=1mm,alpha=2",
            ["alpha", "above 1"],
        ),
    ] {
        let said = describe(kind, text).unwrap_err().to_string();
        for part in parts {
            assert!(said.contains(part), "{text}: {said}");
        }
    }
}

proptest::proptest! {
    #[test]
    fn no_text_panics(text in "\\PC{0,80}", file in "\\PC{0,200}") {
        for kind in [DesignKind::Beam, DesignKind::Spring, DesignKind::Pendulum, DesignKind::Free] {
            let _ = describe(kind, &text);
        }
        let _ = ModesTable::parse("x.csv", &file);
        let _ = ModesTable::parse("x.toml", &file);
    }

    #[test]
    fn beams_of_any_scale_come_back(
        length in -5.0f64..1.0, slenderness in 1.0f64..3.0, mass in -3.0f64..3.0, modes in 1usize..5,
    ) {
        let length = 10f64.powf(length);
        let t = length / 10f64.powf(slenderness);
        let end = 10f64.powf(mass) * 2330.0 * length * t * t;
        let text = format!("L={length},W={t},t={t},material=Si,mass={end},modes={modes},ground={t},film={t},plate={t}x{t},force=1uN/V");
        let made = match describe(DesignKind::Beam, &text) {
            Ok(made) => made,
            // Short and thick ones are faster than any device.
            Err(error) => {
                proptest::prop_assert!(error.to_string().contains("above 10 MHz"), "{}", error);
                return Ok(());
            }
        };
        let again = Preset::parse("own.toml", &made.preset.to_toml()).unwrap();
        proptest::prop_assert_eq!(again, made.preset);
    }
}
