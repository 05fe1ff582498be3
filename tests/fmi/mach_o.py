"""Reads what the tests need from shared libraries for macOS (Mach-O, 64 bits, one processor).

Layouts: `mach-o/loader.h`, `mach-o/nlist.h` and `kern/cs_blobs.h` of Apple's open-source kernel (XNU).
"""

import hashlib
import struct
from dataclasses import dataclass, field
from itertools import pairwise

MAGIC = 0xFEEDFACF
DYLIB = 6
PROCESSORS = {0x01000007: "x86_64", 0x0100000C: "arm64"}
SYMTAB, LOAD_DYLIB, ID_DYLIB, RPATH, CODE_SIGNATURE, BUILD_VERSION, VERSION_MIN_MACOSX = 0x2, 0xC, 0xD, 0x8000001C, 0x1D, 0x32, 0x24
EXPORTS_TRIE, DYLD_INFO, DYLD_INFO_ONLY = 0x80000033, 0x22, 0x80000022
EXTERNAL, PRIVATE, UNDEFINED, DEBUG = 0x01, 0x10, 0x00, 0xE0
CODE_DIRECTORY, SUPER_BLOB, AD_HOC = 0xFADE0C02, 0xFADE0CC0, 0x2


@dataclass
class Library:
    """A shared library."""

    processor: str
    kind: int  # 6 is a shared library
    name: str = ""  # its install name
    needed: list = field(default_factory=list)  # install names of the libraries that it loads
    run_paths: list = field(default_factory=list)
    oldest_macos: tuple = ()
    defined: set = field(default_factory=set)  # exported symbols, by the table of symbols
    exported: set = field(default_factory=set)  # exported symbols, by the tree that the loader searches
    undefined: set = field(default_factory=set)
    signature: bytes = b""
    signature_offset: int = 0


def read(content):
    """The library in the bytes of a file."""
    magic, processor, _, kind, count, _, _, _ = struct.unpack_from("<8I", content)
    assert magic == MAGIC, f"not Mach-O with 64 bits: {magic:#x}"
    library = Library(PROCESSORS[processor], kind)
    at = 32
    for _ in range(count):
        command, size = struct.unpack_from("<2I", content, at)
        words = struct.unpack_from(f"<{(size - 8) // 4}I", content, at + 8)
        named = command in (ID_DYLIB, LOAD_DYLIB, RPATH)
        text = content[at + words[0] : at + size].split(b"\0")[0].decode() if named else ""
        if command == ID_DYLIB:
            library.name = text
        elif command == LOAD_DYLIB:
            library.needed.append(text)
        elif command == RPATH:
            library.run_paths.append(text)
        elif command == BUILD_VERSION:
            assert words[0] == 1, "platform macOS"
            library.oldest_macos = (words[1] >> 16, words[1] >> 8 & 255)
        elif command == VERSION_MIN_MACOSX:
            library.oldest_macos = (words[0] >> 16, words[0] >> 8 & 255)
        elif command == SYMTAB:
            read_symbols(content, words, library)
        elif command == EXPORTS_TRIE:
            library.exported = set(trie(content[words[0] : words[0] + words[1]]))
        elif command in (DYLD_INFO, DYLD_INFO_ONLY):
            library.exported = set(trie(content[words[8] : words[8] + words[9]]))
        elif command == CODE_SIGNATURE:
            library.signature_offset = words[0]
            library.signature = content[words[0] : words[0] + words[1]]
        at += size
    return library


def read_symbols(content, words, library):
    """Symbols of other libraries, and those that the library defines for others."""
    offset, count, names, size = words
    table = content[names : names + size]
    for i in range(count):
        name, kind, _, _, _ = struct.unpack_from("<IBBHQ", content, offset + 16 * i)
        if kind & DEBUG or not kind & EXTERNAL or kind & PRIVATE:
            continue
        text = table[name : table.index(b"\0", name)].decode()
        (library.undefined if kind & 0x0E == UNDEFINED else library.defined).add(text)


def trie(data):
    """Names in a tree of exports: each node has the length of its information, that information, and its branches."""

    def number(at):
        value = shift = 0
        while True:
            value |= (data[at] & 127) << shift
            shift += 7
            at += 1
            if data[at - 1] < 128:
                return value, at

    open_nodes = [(0, "")] if data else []
    while open_nodes:
        at, name = open_nodes.pop()
        size, at = number(at)
        if size:
            yield name
        at += size
        branches, at = data[at], at + 1
        for _ in range(branches):
            end = data.index(b"\0", at)
            node, following = number(end + 1)
            open_nodes.append((node, name + data[at:end].decode()))
            at = following


def signature_faults(content, library):
    """What is wrong with an ad-hoc signature: none, not ad hoc, pages whose hashes differ from their contents, or bytes outside it."""
    if not library.signature:
        return ["no signature"]
    magic, _, count = struct.unpack_from(">3I", library.signature)
    assert magic == SUPER_BLOB
    offsets = [struct.unpack_from(">2I", library.signature, 12 + 8 * i)[1] for i in range(count)]
    directories = [at for at in offsets if struct.unpack_from(">I", library.signature, at)[0] == CODE_DIRECTORY]
    faults = [] if directories else ["no list of hashes"]
    for at in directories:
        _, _, _, flags, hashes, _, _, pages, limit, size, kind, _, log_page = struct.unpack_from(">9I4B", library.signature, at)
        bounds = [*range(0, limit, 1 << log_page), limit]
        if not flags & AD_HOC:
            faults.append("not ad hoc")
        if (kind, size) != (2, 32):
            faults.append(f"hashes of kind {kind}, not SHA-256")
        if limit != library.signature_offset:
            faults.append(f"covers {limit} of {library.signature_offset} bytes")
        if pages != len(bounds) - 1:
            faults.append(f"{pages} hashes for {len(bounds) - 1} pages")
        for i, (begin, end) in enumerate(pairwise(bounds)):
            stored = library.signature[at + hashes + 32 * i : at + hashes + 32 * i + 32]
            if hashlib.sha256(content[begin:end]).digest() != stored:
                faults.append(f"page {i} differs from its hash")
    return faults
