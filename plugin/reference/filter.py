#!/usr/bin/python3
"""Doxygen's filter for the headers: what a comment says of a setter it says of the getter below it and of the member of that name,
too, and functions that override OpenSceneGraph's are called so. The dots of a range end no sentence. usage: filter.py HEADER"""

import re
import sys

lines = open(sys.argv[1]).read().split("\n")
setters = set(re.findall(r"void set(\w+)\(", "\n".join(lines)))
out = []
setter = None  # name of the setter that the last declaration was
for index, line in enumerate(lines):
    text = line.strip()
    indent = line[: len(line) - len(text)]
    above = re.sub(r"\s*///?<.*", "", lines[index - 1]).strip() if index else ""
    is_first = not above or above.endswith((";", "}", "{", ":")) or above.startswith("META_") or re.match(r"//[^/]", above)
    getter = re.match(r"[\w:&*<>, ]+[ &*](?:get|is)(\w+)\(\) const", text)
    if getter and setter == getter[1] and is_first:
        out.append(f"{indent}/// Returns what set{setter}() sets.")
    elif re.search(r"\) (const )?override", text) and is_first:
        out.append(f"{indent}/// Overrides what OpenSceneGraph, or the base, declares.")
    elif re.search(r"\) = default;", text) and is_first:
        out.append(f"{indent}/// As the compiler makes it.")
    elif re.match(r"(\w+)\(const \1& other", text) and is_first:
        out.append(f"{indent}/// Copies as OpenSceneGraph's nodes do.")
    elif (found := re.match(r"enum (\w+)( : int)?$", text)) and is_first:
        out.append(f"{indent}/// Values of what is called {found[1]}.")
    elif (found := re.match(r"[\w:]+ (\w+?)(?:_ms)?(?: = [^;]+)?;$", text)) and is_first and found[1][:1].upper() + found[1][1:] in setters:
        out.append(f"{indent}/// What set{found[1][:1].upper() + found[1][1:]}() sets.")
    found = re.match(r"(?:static )?void set(\w+)\(", text)
    if found:
        setter = found[1]
    elif getter:
        setter = None
    out.append(re.sub(r"\.\.( |$)", r"..\\ ", line) if text.startswith("///") else line)
print("\n".join(out))
