//! The model file in the component's memory.

/// Place of the model file: the encoder finds it by its mark and enters the address and length.
#[repr(C)]
struct Place {
    mark: [u8; 16],
    address: u32,
    length: u32,
}

#[used]
static MODEL: Place = Place { mark: *b"FOLDWING MODEL: ", address: 0, length: 0 };

/// The text of the model file; an error without one.
pub fn text() -> Result<&'static str, String> {
    // SAFETY: a valid static; the encoder has changed its initial value, which the compiler must not assume.
    let place = unsafe { std::ptr::read_volatile(&raw const MODEL) };
    if place.address == 0 {
        return Err("the component contains no model: make it with tools/wasm_fmu.py".to_owned());
    }
    let start = std::ptr::with_exposed_provenance::<u8>(place.address as usize);
    // SAFETY: a data segment that the encoder has added, behind the memory that the module uses.
    let bytes = unsafe { std::slice::from_raw_parts(start, place.length as usize) };
    std::str::from_utf8(bytes).map_err(|error| format!("the model in the component is not UTF-8 text: {error}"))
}
