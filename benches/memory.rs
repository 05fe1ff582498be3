//! Memory per strain set: heap memory of a model, its workspace and a whole plant as a function of the number of sets.
//!
//! `cargo bench -p foldwing-benches --bench memory` (or `make bench`) prints the table of `docs/BENCHMARKS.md`. A counting allocator
//! measures the allocated bytes; the difference between two sizes excludes memory that does not depend on the mesh. These figures do not
//! depend on the load of the computer.

#[allow(dead_code)]
#[path = "../tests/verification/plant/machines.rs"]
mod machines;

use foldwing::beam::section::{Material, Section};
use foldwing::load::LoadFrame;
use foldwing::machine::{ElementKind, Machine, Method};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::model::{Attachment, BodyDescription};
use foldwing::multibody::{Model, Workspace};
use foldwing::plant::Plant;
use nalgebra::{Matrix3, Vector3};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

/// The system's allocator, which counts the allocated bytes.
struct Counting;

static ALIVE: AtomicIsize = AtomicIsize::new(0);

// SAFETY: every call is forwarded unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALIVE.fetch_add(layout.size() as isize, Ordering::Relaxed);
        // SAFETY: forwarded from the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        ALIVE.fetch_sub(layout.size() as isize, Ordering::Relaxed);
        // SAFETY: forwarded from the caller.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        ALIVE.fetch_add(new_size as isize - layout.size() as isize, Ordering::Relaxed);
        // SAFETY: forwarded from the caller.
        unsafe { System.realloc(block, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes on the heap that remain allocated in the result of `make`.
fn held<T>(make: impl FnOnce() -> T) -> (isize, T) {
    let before = ALIVE.load(Ordering::Relaxed);
    let made = make();
    (ALIVE.load(Ordering::Relaxed) - before, made)
}

/// Bytes of the model and workspace of two bodies connected by a hinge.
fn recursions(kind: ElementKind, sets: usize) -> [isize; 2] {
    let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 1.0e9, density_kg_m3: 1425.0 };
    let body = |parent, joint| BodyDescription {
        length_m: 0.15,
        section: Section::rectangle(0.05, 0.002, &material, Some(0.18)).into(),
        kind,
        elements: per_body(kind, sets),
        natural_strain: [0.0; 4].into(),
        offset_m: Vector3::zeros(),
        parent,
        mount: Matrix3::identity(),
        joint,
        masses: Vec::new(),
        stations_m: Vec::new(),
        load_frame: LoadFrame::Root,
    };
    let bodies = [
        body(Attachment::Root(Vector3::zeros()), JointKind::Clamped),
        body(Attachment::Body { index: 0, position_m: 0.15 }, JointKind::Revolute { axis: Vector3::y() }),
    ];
    let (model_bytes, model) = held(|| Model::new(&bodies));
    let (workspace_bytes, _workspace) = held(|| Workspace::new(&model));
    [model_bytes, workspace_bytes]
}

/// Bytes of a plant that has run (model, workspace, state, integrator, outputs), and of one snapshot of its state.
fn plant(kind: ElementKind, sets: usize) -> [isize; 2] {
    let machine: Machine = machines::wing(kind, per_body(kind, sets), Method::Esdirk4, 1e-4);
    let machine = Arc::new(machine);
    let (plant_bytes, plant) = held(|| {
        let mut plant = Plant::new(Arc::clone(&machine));
        plant.initialize(0.0).expect("it starts");
        plant.step(1e-3).expect("it steps");
        plant
    });
    let (snapshot_bytes, _snapshot) = held(|| plant.snapshot());
    [plant_bytes, snapshot_bytes]
}

/// Elements in each of the two bodies; a pair is two strain sets.
fn per_body(kind: ElementKind, sets: usize) -> usize {
    if kind == ElementKind::Linear { sets / 4 } else { sets / 2 }
}

fn main() {
    const SIZES: [usize; 2] = [64, 512];
    println!(
        "| bytes per strain set | model | workspace | whole plant | snapshot of its state |\n|---|---|---|---|---|"
    );
    for (kind, name) in [(ElementKind::Constant, "constant"), (ElementKind::Linear, "pairs")] {
        let [small, large] = SIZES.map(|sets| {
            let ([model, workspace], [plant, snapshot]) = (recursions(kind, sets), plant(kind, sets));
            [model, workspace, plant, snapshot]
        });
        let cells: String =
            large.iter().zip(small).map(|(l, s)| format!(" {} |", (l - s) / (SIZES[1] - SIZES[0]) as isize)).collect();
        println!("| {name} |{cells}");
    }
    let [whole, _] = plant(ElementKind::Linear, 16);
    println!("\nA plant of the shipped mesh (16 strain sets) holds {:.0} kB.", whole as f64 / 1e3);
}
