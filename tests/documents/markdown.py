"""What documents have in them: fenced blocks with the comments before them, spans of code, links to pictures."""

import dataclasses
import re

COMMENT = re.compile(r"<!--\s*(.*?)\s*-->", re.DOTALL)
WORDS = ("not run", "long", "given", "file", "where", "ends")


@dataclasses.dataclass
class Block:
    """A fenced block. marks: what the HTML comments right before it say, by their first word."""

    document: str
    line: int
    language: str
    text: str
    marks: dict

    @property
    def place(self):
        return f"{self.document}:{self.line}"


def marks_before(lines, index):
    """The comments that end right above line index, as a dictionary; a comment that isn't one of ours is left alone."""
    above = "\n".join(lines[:index])
    marks = {}
    while match := re.search(r"<!--((?:(?!-->).)*)-->\s*\Z", above, re.DOTALL):
        word, _, rest = match[1].strip().partition(":")
        if word in WORDS:
            if not rest.strip():
                raise ValueError(f"line {index}: the comment \"{word}\" says nothing")
            marks[word] = " ".join(rest.split()) if word != "given" else rest.strip()
        above = above[: match.start()]
    return marks


def blocks_of(document, text):
    """All fenced blocks. Raises ValueError for one without an end, and for code that is indented and not fenced."""
    lines = text.split("\n")
    found = []
    index = 0
    while index < len(lines):
        line = lines[index]
        fence = re.match(r"( *)```(\S*)\s*$", line)
        if fence:
            end = next((i for i in range(index + 1, len(lines)) if lines[i].strip() == "```"), None)
            if end is None:
                raise ValueError(f"{document}:{index + 1}: the block has no end")
            body = "\n".join(each[len(fence[1]):] for each in lines[index + 1: end]) + "\n"
            found.append(Block(document, index + 1, fence[2], body, marks_before(lines, index)))
            index = end + 1
            continue
        # Four blanks after an empty line are code to Markdown, unless they go on with a list.
        if line.startswith("    ") and line.strip() and index and not lines[index - 1].strip():
            before = next((each for each in reversed(lines[:index]) if each and not each.startswith(" ")), "")
            if not re.match(r"[-*] |\d+\. ", before):
                raise ValueError(f"{document}:{index + 1}: a block without a fence, so without a language")
        index += 1
    return found


def prose_of(text):
    """The text without its blocks and comments."""
    return COMMENT.sub("", re.sub(r"^( *)```.*?^ *```", "", text, flags=re.MULTILINE | re.DOTALL))


def spans_of(text):
    """Spans of code in the prose."""
    return [" ".join(each.split()) for each in re.findall(r"`([^`]+)`", prose_of(text))]


def pictures_of(text):
    """Files of the pictures that are shown."""
    return re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", prose_of(text))
