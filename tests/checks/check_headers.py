#!/usr/bin/env python3
"""Refuses a header that names what neither it nor a header of this project that it includes brings: a name of the
standard library or of another library, or a type of this project. Builds do not tell, as precompiled headers and sources
that are compiled together bring it by chance. The target all_verify_interface_header_sets compiles each header alone,
which tells the same, and more, in a hundred times the time.

usage: check_headers.py ROOT | --self-test
"""
import functools
import pathlib
import re
import sys
import tempfile

from check_layers import FRONT_DOOR, INCLUDE, LAYERS, TYPE

# Which header brings a name of namespace std; a name that is in none of these is an error.
STANDARD = {
    "algorithm": "all_of any_of clamp copy copy_n count count_if fill find max min none_of partition_point sort transform",
    "array": "array",
    "atomic": "atomic memory_order_relaxed",
    "bit": "bit_cast bit_width countl_zero endian has_single_bit",
    "charconv": "from_chars to_chars",
    "chrono": "chrono",
    "cmath": "abs acos asin atan2 ceil cos exp fabs floor fmod hypot isfinite isinf isnan ldexp log log2 lround pow round sin sqrt tan",
    "complex": "complex",
    "csignal": "sig_atomic_t",
    "cstddef": "byte nullptr_t ptrdiff_t size_t",
    "cstdint": "int8_t int16_t int32_t int64_t intptr_t uint8_t uint16_t uint32_t uint64_t uintptr_t",
    "cstdio": "FILE",
    "cstring": "memcpy",
    "exception": "exception",
    "filesystem": "filesystem",
    "functional": "function",
    "initializer_list": "initializer_list",
    "limits": "numeric_limits",
    "list": "list",
    "map": "map",
    "memory": "make_shared make_unique shared_ptr unique_ptr weak_ptr",
    "mutex": "call_once lock_guard mutex once_flag recursive_mutex scoped_lock unique_lock",
    "numbers": "numbers",
    "optional": "nullopt nullopt_t optional",
    "random": "mt19937 mt19937_64",
    "set": "set",
    "span": "as_bytes as_writable_bytes dynamic_extent span",
    "stdexcept": "runtime_error",
    "string": "string to_string",
    "string_view": "string_view",
    "system_error": "errc error_code",
    "thread": "thread",
    "tuple": "tie tuple",
    "type_traits": "conditional_t decay_t enable_if_t false_type invoke_result_t is_arithmetic_v is_same_v remove_cvref_t true_type",
    "unordered_map": "unordered_map",
    "utility": "declval exchange forward move pair swap",
    "variant": "get_if holds_alternative monostate variant visit",
    "vector": "vector",
}
# A name of another namespace, and what the header that brings it begins with.
OTHERS = {"glm": "glm/", "fmt": "fmt/", "nlohmann": "nlohmann/", "tbb": "tbb/", "Eigen": "Eigen/", "pugi": "pugixml"}
HOME = {name: header for header, names in STANDARD.items() for name in names.split()}
# Headers that bring what others are named for, by the standard.
ALSO = {"string": {"string_view", "initializer_list"}, "vector": {"initializer_list"}, "map": {"initializer_list"}}
EITHER = {"size_t": {"cstddef", "cstdio", "cstring", "string", "vector", "array", "span", "memory", "functional"}}
REMARK = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)
NAME = re.compile(r"\b(?<!::)(\w+)::(\w+)")
WORD = re.compile(r"(?<![\w:.>])([A-Z]\w+)\b")
DECLARED = re.compile(r"\b(?:class|struct|enum class|using|typename|enum) (\w+)")


class Tree:
    def __init__(self, root):
        self.root = root
        self.headers = sorted(p for layer in LAYERS[:-1] for p in (root / layer).rglob("*.h")
                              if not p.name.endswith("_inl.h"))
        self.texts = {p: p.read_text(encoding="utf-8") for p in self.headers}
        self.types = {}
        for path, text in self.texts.items():
            for match in TYPE.finditer(text):
                self.types.setdefault(match.group(1), set()).add(path)

    @functools.lru_cache(maxsize=None)
    def reached(self, path):
        """What a header includes, itself or through headers of this project: (their names, their paths)."""
        names, paths = set(), {path}
        for _, name in INCLUDE.findall(self.texts[path]):
            names.add(name)
            if self.root / name in self.texts:
                more_names, more_paths = self.reached(self.root / name)
                names |= more_names
                paths |= more_paths
        return names | {name for header in names for name in ALSO.get(header, ())}, paths

    def missing(self, path):
        """What a header names without including it: (name, what would bring it)."""
        text = REMARK.sub("", INCLUDE.sub("", self.texts[path]))
        names, paths = self.reached(path)
        for space, name in sorted(set(NAME.findall(text))):
            if space == "std":
                homes = EITHER.get(name, {HOME.get(name)})
                if not homes & names:
                    yield f"std::{name}", f"<{HOME[name]}>" if name in HOME else "a header that STANDARD does not list"
            elif space in OTHERS and not any(header.startswith(OTHERS[space]) for header in names):
                yield f"{space}::{name}", f"<{OTHERS[space]}...>"
        if path.relative_to(self.root).as_posix().startswith(FRONT_DOOR):
            return
        declared = set(DECLARED.findall(text))
        for name in sorted(set(WORD.findall(text)) - declared):
            homes = self.types.get(name)
            if homes and not homes & paths:
                yield name, " or ".join(sorted(home.relative_to(self.root).as_posix() for home in homes))


def violations(root):
    tree = Tree(root)
    return [f"{path.relative_to(root)}: names {name}, which {home} brings" for path in tree.headers
            for name, home in tree.missing(path)]


def self_test():
    cases = [
        ("std::vector<int> a();\n", "std::vector"),
        ("#include <vector>\nstd::vector<int> a();\n", None),
        ('#include "codec/base.h"\nstd::vector<int> a(Base);\n', None),
        ("int a(const Base& base);\n", "Base"),
        ("class Base;\nint a(const Base& base);\n", None),
        ("// std::map, Base\nint a();\n", None),
        ("void a(glm::vec3 v);\n", "glm::vec3"),
        ("#include <glm/vec3.hpp>\nvoid a(glm::vec3 v);\n", None),
        ("std::unheard_of a();\n", "std::unheard_of"),
    ]
    for text, wrong in cases:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "codec").mkdir()
            (root / "codec/base.h").write_text("#include <vector>\nclass Base {\n};\n")
            (root / "codec/other.h").write_text(text)
            found = violations(root)
            if (wrong is None) != (not found) or (wrong and f" {wrong}," not in found[0]):
                sys.exit(f"{text!r}: expected {wrong}, found {found}")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = violations(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(found))
    return sys.exit(1) if found else None


if __name__ == "__main__":
    main()
