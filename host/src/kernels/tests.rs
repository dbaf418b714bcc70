//! Tests with folders of the embedded modules, some of which are modified.

use std::path::Path;

use rspirv::binary::Assemble;
use rspirv::dr::Operand;

use super::*;
use caustics_files::hash::fnv1a;
use tempfile::TempDir;

const OWN: [&[u8]; 2] =
    [include_bytes!("../../../kernels/base.spv"), include_bytes!("../../../kernels/rayquery.spv")];

fn lock(interface: &str, [base, rayquery]: [&[u8]; 2]) -> String {
    let hash = |bytes: &[u8]| fnv1a(bytes.iter().copied().chain([0xff]));
    let (base, rayquery) = (hash(base), hash(rayquery));
    format!(
        "sources = \"\"\ninterface = \"{interface}\"\n\"base.spv\" = \"{base}\"\n\"rayquery.spv\" = \"{rayquery}\"\n"
    )
}

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    std::fs::write(folder.join(name), bytes).unwrap();
}

/// Writes a complete set of these modules to a folder.
fn set(folder: &Path, modules: [&[u8]; 2]) {
    write(folder, "base.spv", modules[0]);
    write(folder, "rayquery.spv", modules[1]);
    write(folder, "kernels.lock", lock(env!("CAUSTICS_INTERFACE_HASH"), modules));
}

fn whole() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    set(folder.path(), OWN);
    folder
}

fn refused(folder: &TempDir) -> String {
    Source::Folder(folder.path().into()).modules().unwrap_err().to_string()
}

/// Returns the base module after a change.
fn changed(change: impl FnOnce(&mut rspirv::dr::Module)) -> Vec<u8> {
    let mut module = rspirv::dr::load_bytes(OWN[0]).unwrap();
    change(&mut module);
    module.assemble().into_iter().flat_map(u32::to_le_bytes).collect()
}

#[test]
fn kernels_of_a_folder_are_loaded() {
    let folder = whole();
    let modules = Source::Folder(folder.path().into()).modules().unwrap();
    assert_eq!([modules.base, modules.rayquery], OWN.map(words));
}

#[test]
fn errors_of_incomplete_folders_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    assert!(refused(&folder).contains("kernels.lock is missing"), "{}", refused(&folder));
    write(folder.path(), "kernels.lock", "base.spv");
    assert!(refused(&folder).contains("kernels.lock"), "{}", refused(&folder));
    write(folder.path(), "kernels.lock", lock(env!("CAUSTICS_INTERFACE_HASH"), OWN));
    assert!(refused(&folder).contains("cannot read"), "{}", refused(&folder));
    assert!(refused(&folder).contains("base.spv"), "{}", refused(&folder));
}

#[test]
fn another_interface_is_reported_before_other_errors() {
    let folder = whole();
    write(folder.path(), "base.spv", "of another interface");
    for text in [lock("0123456789abcdef", OWN), lock("", OWN).replace("interface = \"\"", "")] {
        write(folder.path(), "kernels.lock", text);
        let message = refused(&folder);
        assert!(message.contains("interface") && message.contains("cargo build --release"), "{message}");
    }
}

#[test]
fn the_error_of_a_half_written_module_names_it() {
    let folder = whole();
    write(folder.path(), "rayquery.spv", &OWN[1][..OWN[1].len() / 2]);
    let message = refused(&folder);
    assert!(message.contains("rayquery.spv is not whole"), "{message}");
}

#[test]
fn modules_whose_entry_points_do_not_fit_the_passes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let rename = |module: &mut rspirv::dr::Module, from: &str, to: &str| {
        let names = module.debug_names.iter_mut().chain(&mut module.entry_points);
        for operand in names.flat_map(|name| &mut name.operands) {
            if *operand == Operand::LiteralString(from.into()) {
                *operand = Operand::LiteralString(to.into());
            }
        }
    };

    let base = changed(|module| rename(module, "caustic_radiance", "caustic_light"));
    set(folder.path(), [&base, OWN[1]]);
    let message = refused(&folder);
    assert!(message.contains("of base.spv binds `caustic_light`"), "{message}");
    assert!(message.contains("cargo build --release"), "{message}");

    let base = changed(|module| rename(module, "gather.brute", "gather.rough"));
    set(folder.path(), [&base, OWN[1]]);
    assert!(refused(&folder).contains("base.spv has no entry point `gather.brute`"), "{}", refused(&folder));

    // Enlarge the elements of a table by a word.
    let base = changed(|module| {
        let stride = |operands: &[Operand]| {
            operands.contains(&Operand::Decoration(rspirv::spirv::Decoration::ArrayStride))
        };
        let strides = module.annotations.iter_mut().filter(|i| stride(&i.operands));
        for operand in strides.flat_map(|i| &mut i.operands) {
            if *operand == Operand::LiteralBit32(36) {
                *operand = Operand::LiteralBit32(40);
            }
        }
    });
    set(folder.path(), [&base, OWN[1]]);
    let message = refused(&folder);
    assert!(message.contains("`triangles` with elements of 40 bytes"), "{message}");
    assert!(message.contains("have 36"), "{message}");
}

/// An entry point without a pass, such as one of a future version, is ignored.
#[test]
fn entry_points_without_a_pass_are_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let more = changed(|module| {
        let entry = module.entry_points[0].clone();
        module.entry_points.push(entry);
        let last = module.entry_points.last_mut().unwrap();
        last.operands[2] = Operand::LiteralString("gather.to_come".into());
    });
    set(folder.path(), [&more, OWN[1]]);
    Source::Folder(folder.path().into()).modules().unwrap();
}

#[test]
fn embedded_kernels_pass_the_check() {
    check::modules(OWN.map(words).each_ref().map(|module| &module[..])).unwrap();
}

#[test]
fn a_new_set_is_reported_once_and_only_when_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut watch = Watch::new(path.into());
    assert!(!watch.has_new());
    let interface = env!("CAUSTICS_INTERFACE_HASH");

    // Write in the builder's order: modules, then the lock.
    write(path, "base.spv", "one");
    write(path, "rayquery.spv", "one, too");
    assert!(!watch.has_new());
    write(path, "kernels.lock", lock(interface, [b"one", b"one, too"]));
    assert!(watch.has_new());
    assert!(!watch.has_new());

    // Write the lock first.
    write(path, "kernels.lock", lock(interface, [b"two", b"two, too"]));
    assert!(!watch.has_new());
    write(path, "base.spv", "two");
    assert!(!watch.has_new());
    write(path, "rayquery.spv", "two, too");
    assert!(watch.has_new());
    assert!(!watch.has_new());

    // The same set again is not new; the same modules with another interface are.
    write(path, "kernels.lock", format!("# A remark.\n{}", lock(interface, [b"two", b"two, too"])));
    assert!(!watch.has_new());
    write(path, "kernels.lock", lock("", [b"two", b"two, too"]));
    assert!(watch.has_new());

    // A set that exists at the start is not new.
    assert!(!Watch::new(path.into()).has_new());
    // A removed folder has no new set.
    folder.close().unwrap();
    assert!(!watch.has_new());
}
