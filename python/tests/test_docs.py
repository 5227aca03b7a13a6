"""Docstrings: every public name has one, and their examples give what they say."""

from __future__ import annotations

import doctest
import inspect
from typing import Any, Iterator

import pytest
import tirtouch
import tirtouch.mitsuba


def members(owner: Any, name: str) -> Iterator[tuple[str, Any]]:
    """A name and, of a class of this package, its own public methods and properties."""
    yield name, owner
    if inspect.isclass(owner):
        for member in vars(owner):
            if not member.startswith("_"):
                yield f"{name}.{member}", getattr(owner, member)


def public() -> Iterator[tuple[str, Any]]:
    for module in (tirtouch, tirtouch.mitsuba):
        yield module.__name__, module
        for name in module.__all__:
            if not name.startswith("_"):
                yield from members(getattr(module, name), f"{module.__name__}.{name}")


PUBLIC = dict(public())
EXAMPLES = [
    example
    for name, documented in PUBLIC.items()
    if (example := doctest.DocTestParser().get_doctest(documented.__doc__ or "", {}, name, None, None)).examples
]


def test_every_public_name_has_a_docstring() -> None:
    assert "tirtouch.Image.radiance" in PUBLIC and "tirtouch.mitsuba.to_mitsuba" in PUBLIC
    assert [name for name, documented in PUBLIC.items() if not (documented.__doc__ or "").strip()] == []


@pytest.mark.parametrize("owner", [tirtouch.Session, tirtouch.Sweep])
def test_a_class_says_what_its_constructor_takes(owner: type) -> None:
    # Python shows no docstring of the constructor of a compiled class.
    said = owner.__doc__ or ""
    assert [name for name in inspect.signature(owner).parameters if f"``{name}``" not in said] == []


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: str(example.name))
def test_examples_give_what_they_say(example: doctest.DocTest) -> None:
    if "mitsuba" in example.name:
        pytest.skip("needs Mitsuba and an LLVM that it takes")
    told: list[str] = []
    assert doctest.DocTestRunner().run(example, out=told.append).failed == 0, "".join(told)
