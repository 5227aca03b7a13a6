"""Builds the documentation of the package as pages: ``python docs.py FOLDER``; ``docs.sh`` calls it.

pdoc reads Python. Of a compiled class it sees the docstrings, but neither types nor the order of members: those are in
the stub. So the stub is run as the package, each of its names gets its docstring from the compiled one, and pdoc reads
that. What a reader would miss is told, with an exit code of 1: a docstring, a type, or marks that are not shown.
"""

from __future__ import annotations

import __future__

import inspect
import re
import sys
from pathlib import Path
from types import GenericAlias, ModuleType
from typing import Any, Iterator

import numpy.typing
import pdoc
import pdoc.doc
import pdoc.render
import tirtouch

#: Literals and lines of examples.
NO_MARKUP = re.compile(r"``[^`]+``|^(>>>|\.\.\.) .*$", re.MULTILINE)


class NDArray:
    """Shown as it is written, not as the longer type that it stands for."""

    __class_getitem__: Any = classmethod(GenericAlias)
    __module__ = "numpy.typing"


class Unsaid:
    """A default of which a stub says no more than that it is there."""

    def __repr__(self) -> str:
        return "..."


def described_stub() -> ModuleType:
    """The package as its stub has it, with the docstrings of what is compiled."""
    stub = Path(tirtouch.__file__).with_name("_tirtouch.pyi")
    module = ModuleType("tirtouch", tirtouch.__doc__)
    module.__file__, module.__path__, module.__spec__ = str(stub), tirtouch.__path__, tirtouch.__spec__
    code = compile(stub.read_text("utf-8"), stub, "exec", __future__.annotations.compiler_flag, dont_inherit=True)
    exec(code, vars(module))
    vars(module).update(__all__=tirtouch.__all__, __version__=tirtouch.__version__)
    for name in tirtouch.__all__:
        compiled = getattr(tirtouch, name)
        if name not in vars(module):
            setattr(module, name, compiled)
        elif inspect.isclass(compiled) or inspect.isroutine(compiled):
            describe(getattr(module, name), compiled)
    return module


def describe(stub: Any, compiled: Any) -> None:
    stub.__doc__ = compiled.__doc__
    if inspect.isfunction(stub) and stub.__defaults__:
        stub.__defaults__ = tuple(Unsaid() if value is ... else value for value in stub.__defaults__)
    if inspect.isclass(stub):
        if "__new__" in vars(stub):
            stub.__new__.__doc__ = ""  # with None pdoc would not show it
        for name in vars(compiled):
            if not name.startswith("_"):
                describe(getattr(stub, name), getattr(compiled, name))


def missed(doc: pdoc.doc.Doc[Any]) -> Iterator[str]:
    """What a reader would miss of a name and of its members, a line each."""
    if doc.name.startswith("_") and doc.name != "__init__":
        return
    if not doc.docstring and doc.name != "__init__":
        yield f"{doc.fullname}: no docstring"
    if found := re.search("[`*<]", NO_MARKUP.sub("", doc.docstring)):
        yield f"{doc.fullname}: {found[0]!r} is markup outside of a literal: ``like this``"
    if isinstance(doc, pdoc.doc.Function):
        for name, parameter in doc.signature.parameters.items():
            if parameter.annotation is inspect.Parameter.empty and name not in ("self", "cls", "_cls"):
                yield f"{doc.fullname}: no type of {name}"
    if isinstance(doc, pdoc.doc.Variable) and not doc.annotation_str:
        yield f"{doc.fullname}: no type"
    if isinstance(doc, pdoc.doc.Namespace):
        for member in doc.own_members:
            yield from missed(member)


def main(folder: Path) -> None:
    numpy.typing.NDArray = NDArray  # type: ignore[assignment]
    sys.modules["tirtouch"] = described_stub()
    names = ["tirtouch", "tirtouch.mitsuba"]
    pdoc.render.configure(show_source=False, footer_text=f"tirtouch {tirtouch.__version__}")
    pdoc.pdoc(*names, output_directory=folder)
    lines = [line for name in names for line in missed(pdoc.doc.Module.from_name(name))]
    sys.exit("\n".join(lines) or None)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
