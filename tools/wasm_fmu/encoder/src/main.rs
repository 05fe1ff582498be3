//! Makes a component from the core module of `foldwing-component` and a model file:
//!
//!     encoder CORE.wasm MODEL.toml COMPONENT.wasm
//!
//! A component has no access to the files of the FMU unless the importer offers it. Therefore the model is a data segment of the module, in
//! pages of memory of its own behind those of the module; the address and length are written into the module's `MODEL`.

use std::borrow::Cow;
use std::error::Error;
use wasm_encoder::{DataCountSection, DataSection, DataSegmentMode, MemorySection, MemoryType, RawSection};
use wasm_encoder::{ConstExpr, Module};
use wasmparser::{DataKind, Operator, Parser, Payload};

/// First bytes of the module's `MODEL`; its address and its length follow, in four bytes each.
const MARK: &[u8; 16] = b"FOLDWING MODEL: ";
/// Bytes in a page of memory.
const PAGE: u64 = 65536;

/// The module with the model in its memory.
///
/// # Errors
/// The module is invalid, has not exactly one memory, or not exactly one place for the address of the model.
fn with_model(core: &[u8], model: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut module = Module::new();
    let (mut start, mut places) = (None, 0);
    for payload in Parser::new(0).parse_all(core) {
        match payload? {
            Payload::MemorySection(reader) => {
                let [memory] = reader.into_iter().collect::<Result<Vec<_>, _>>()?[..] else {
                    return Err("the module has several memories".into());
                };
                let minimum = memory.initial + (model.len() as u64).div_ceil(PAGE);
                if memory.memory64 || memory.shared || memory.maximum.is_some_and(|maximum| maximum < minimum) {
                    return Err(format!("the module's memory has no room for {} bytes of model", model.len()).into());
                }
                start = Some(u32::try_from(memory.initial * PAGE)?);
                let mut section = MemorySection::new();
                section.memory(MemoryType {
                    minimum,
                    maximum: memory.maximum,
                    memory64: false,
                    shared: false,
                    page_size_log2: memory.page_size_log2,
                });
                module.section(&section);
            }
            Payload::DataCountSection { count, .. } => {
                module.section(&DataCountSection { count: count + 1 });
            }
            Payload::DataSection(reader) => {
                let start = start.ok_or("the module has no memory")?;
                let mut section = DataSection::new();
                for segment in reader {
                    let segment = segment?;
                    let mut bytes = segment.data.to_vec();
                    let marks: Vec<usize> =
                        (0..bytes.len()).filter(|&at| bytes[at..].starts_with(MARK)).map(|at| at + MARK.len()).collect();
                    for at in marks {
                        let place = bytes.get_mut(at..at + 8).ok_or("the place of the model is cut off")?;
                        place[..4].copy_from_slice(&start.to_le_bytes());
                        place[4..].copy_from_slice(&u32::try_from(model.len())?.to_le_bytes());
                        places += 1;
                    }
                    let mode = match segment.kind {
                        DataKind::Passive => DataSegmentMode::Passive,
                        DataKind::Active { memory_index, offset_expr } => {
                            let mut operators = offset_expr.get_operators_reader();
                            let Operator::I32Const { value } = operators.read()? else {
                                return Err("the place of a data segment is not a number".into());
                            };
                            DataSegmentMode::Active { memory_index, offset: &ConstExpr::i32_const(value) }
                        }
                    };
                    section.segment(wasm_encoder::DataSegment { mode, data: bytes.iter().copied() });
                }
                section.active(0, &ConstExpr::i32_const(start.cast_signed()), model.iter().copied());
                module.section(&section);
            }
            Payload::CustomSection(reader) => {
                module.section(&wasm_encoder::CustomSection {
                    name: Cow::Borrowed(reader.name()),
                    data: Cow::Borrowed(reader.data()),
                });
            }
            other => {
                if let Some((id, range)) = other.as_section() {
                    let range = usize::try_from(range.start)?..usize::try_from(range.end)?;
                    module.section(&RawSection { id, data: &core[range] });
                }
            }
        }
    }
    if places != 1 {
        return Err(format!("the module has {places} places for the address of a model instead of one").into());
    }
    Ok(module.finish())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [core, model, output] = &arguments[..] else {
        return Err("encoder CORE.wasm MODEL.toml COMPONENT.wasm".into());
    };
    let module = with_model(&std::fs::read(core)?, &std::fs::read(model)?)?;
    let component = wit_component::ComponentEncoder::default().validate(true).module(&module)?.encode()?;
    std::fs::write(output, component)?;
    Ok(())
}
