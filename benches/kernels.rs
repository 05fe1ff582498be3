//! Cost of the recursions over the number of elements: exponentials, residual, factorisation, solve, statics; and of the
//! vortex lattice's kernel per segment and point.
//!
//! `cargo bench -p foldwing-benches --bench kernels` (or `make bench`); results are listed in `docs/BENCHMARKS.md`.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use foldwing::aero::biot_savart::{Arm, Block, Filaments, Kernel, LANES, Sheet};
use foldwing::beam::element::ElementKind;
use foldwing::beam::section::{Material, Section};
use foldwing::config;
use foldwing::load::{LoadFrame, RootMotion};
use foldwing::math::se3::LinkGeometry;
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::factor::{FreedomTangent, Weights, factorize, solve};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::{Attachment, BodyDescription};
use foldwing::multibody::{Model, Workspace};
use foldwing::plant::{Holding, Plant};
use nalgebra::{Matrix3, Vector3};
use std::hint::black_box;
use std::sync::Arc;

/// Two bodies connected by a hinge, with `sets` strain sets in total, bent and moving.
struct Case {
    model: Model,
    work: Workspace,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    out: Vec<f64>,
}

impl Case {
    fn new(kind: ElementKind, sets: usize) -> Self {
        let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 1.0e9, density_kg_m3: 1425.0 };
        let body = |parent, joint| BodyDescription {
            length_m: 0.15,
            section: Section::rectangle(0.05, 0.002, &material, Some(0.18)).into(),
            kind,
            elements: if kind == ElementKind::Linear { sets / 4 } else { sets / 2 },
            natural_strain: [0.0; 4].into(),
            offset_m: Vector3::zeros(),
            parent,
            mount: Matrix3::identity(),
            joint,
            masses: Vec::new(),
            stations_m: Vec::new(),
            load_frame: LoadFrame::Root,
        };
        let model = Model::new(&[
            body(Attachment::Root(Vector3::zeros()), JointKind::Clamped),
            body(Attachment::Body { index: 0, position_m: 0.15 }, JointKind::Revolute { axis: Vector3::y() }),
        ]);
        let wave = |scale: f64| (0..model.coordinates).map(|i| scale * (1.7 * i as f64).sin()).collect();
        Self {
            work: Workspace::new(&model),
            q: wave(0.5),
            v: wave(3.0),
            a: wave(100.0),
            out: vec![0.0; model.coordinates],
            model,
        }
    }

    fn residual(&mut self) {
        let environment = Environment { root: &RootMotion::default(), damping: &DAMPING, stations: &[] };
        let motion = Motion { q: &self.q, v: &self.v, a: &self.a };
        residual(&self.model, &mut self.work, motion, environment, &mut self.out);
    }

    fn factorize(&mut self) {
        let weights = Weights { mass: 1.0, damping: 1e-4, stiffness: 1e-8 };
        let tangent = FreedomTangent { free: true, stiffness: 0.026, damping: 8e-4 };
        factorize(&self.model, &mut self.work, weights, &DAMPING, &[tangent; 2]).expect("positive definite");
    }

    /// Poses, Jacobians and rates of all links, as in the outward sweep.
    fn exponentials(&self) -> Matrix3<f64> {
        let mut frame = Matrix3::identity();
        for (strain, rate) in self.q.as_chunks::<4>().0.iter().zip(self.v.as_chunks::<4>().0) {
            let (geometry, link) = LinkGeometry::new(&frame, 0.01, strain);
            black_box(geometry.rates(&frame, rate));
            frame = link.rotation;
        }
        frame
    }

    fn solve(&mut self) -> f64 {
        solve(&self.model, &mut self.work, &mut self.out)
    }
}

const DAMPING: [Damping; 2] = [Damping { mass_1_s: 2.5, stiffness_s: 0.0, strain_inertia_s2: 0.0 }; 2];

fn kernels(criterion: &mut Criterion) {
    for (kind, name) in [(ElementKind::Constant, "constant"), (ElementKind::Linear, "linear")] {
        let mut group = criterion.benchmark_group(name);
        for sets in [4, 8, 16, 32, 64, 128, 256, 512, 1024] {
            let mut case = Case::new(kind, sets);
            case.residual();
            group.throughput(Throughput::Elements(sets as u64));
            group.bench_function(BenchmarkId::new("exponentials", sets), |b| b.iter(|| case.exponentials()));
            group.bench_function(BenchmarkId::new("residual", sets), |b| b.iter(|| case.residual()));
            group.bench_function(BenchmarkId::new("factorize", sets), |b| b.iter(|| case.factorize()));
            group.bench_function(BenchmarkId::new("solve", sets), |b| {
                b.iter(|| {
                    case.out.fill(1.0);
                    black_box(case.solve())
                });
            });
        }
        group.finish();
    }
    let mut case = Case::new(ElementKind::Constant, 30);
    criterion.bench_function("30 elements: residual, factorize, solve", |b| {
        b.iter(|| {
            case.residual();
            case.factorize();
            black_box(case.solve())
        });
    });
}

/// Velocity that a wake of 100 rows and 20 strips induces at eight points: 4120 segments, without shared segments
/// between rows.
///
/// The kernel uses the widest vector instructions of the processor.
fn biot_savart(criterion: &mut Criterion) {
    let (rows, strips) = (100, 20);
    let (columns, rings) = (strips + 1, rows * strips);
    let sheet = Sheet {
        rows,
        strips,
        first_node: 0,
        node_stride: columns,
        first_ring: 0,
        ring_stride: strips,
        joined_rear: false,
    };
    let node = |i: usize| Vector3::new(0.05 * (i / columns) as f64, 0.3 * (i % columns) as f64, 1e-3 * (i % 7) as f64);
    let nodes_m: Vec<_> = (0..(rows + 1) * columns).map(node).collect();
    let circulation_m2_s: Vec<_> = (0..rings).map(|i| (0.3 * i as f64).sin()).collect();
    let mut filaments = Filaments::new(rings + strips, nodes_m.len());
    filaments.gather(&sheet, &circulation_m2_s);
    let kernel = Kernel { core_squared_m2: 1e-6, mirror_normal: None, ground: None, stretch: None };
    let mut points = Block::default();
    for lane in 0..LANES {
        points.set(lane, &Vector3::new(-0.5, 1.0 + lane as f64, 0.2));
    }
    let mut arms = vec![Arm::default(); 2 * columns];
    let segments = (rows + 1) * strips + rows * columns;

    let mut group = criterion.benchmark_group("Biot–Savart");
    group.throughput(Throughput::Elements((segments * LANES) as u64));
    group.bench_function("segment and point", |b| {
        b.iter(|| {
            let mut velocity_m_s = Block::default();
            kernel.induce(&[sheet], &nodes_m, &filaments, &points, &mut arms, &mut velocity_m_s);
            black_box(velocity_m_s)
        });
    });
    group.finish();
}

/// Cost of one static iteration: the time for a cantilever under ten times its weight, from the undeformed state,
/// divided by the number of iterations.
fn statics(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("statics");
    for pairs in [16_u64, 64, 256, 1000] {
        let text = format!(
            "name = \"Cantilever\"\n[section.s]\nshape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.01\n\
             density_kg_m3 = 2700.0\nyoungs_modulus_Pa = 70e9\npoisson_ratio = 0.3\n[body.beam]\nlength_m = 1.0\nsection = \"s\"\n\
             elements = {pairs}\n[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"beam\"\n"
        );
        let mut plant = Plant::new(Arc::new(config::parse(&text, "beam.toml").expect("valid")));
        plant.inputs_mut().root_mut().gravity_m_s2 = Vector3::new(0.0, 0.0, -100.0);
        let effort = plant.study().equilibrium(0.0, Holding::AsReleased).expect("rests");
        group.throughput(Throughput::Elements(pairs * effort.iterations as u64));
        group.bench_function(BenchmarkId::new("equilibrium", pairs), |b| {
            b.iter(|| black_box(plant.study().equilibrium(0.0, Holding::AsReleased)));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30).warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_millis(1000));
    targets = kernels, statics, biot_savart
}
criterion_main!(benches);
