"""The house: modules in layers, no circles, nothing reaches back; drawn from the imports themselves."""

import ast
from functools import cache
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src" / "myostrain"

#: Layers from the ground up. A part imports from those below it and from its own folder, never from above;
#: parts of one layer do not know each other. A name is a folder, or a module at the top.
LAYERS = [
    {"errors", "type_words"},
    {"kernel_cache", "blas"},
    {"engine"},
    {"validation", "state"},
    {"history", "course", "directions", "pointwise"},
    {"circulation", "geometry", "kinematics", "materials", "membranes", "activation", "theory"},
    {"solvers"},
    {"electrics", "mechanics"},
    {"transfer", "schemes"},
    {"coupling"},
    {"output"},
    {"run"},
    {"single_cell"},
    {"conduction"},
    {"case"},
    {"reproduce", "doctor", "sweeping"},
    {"cli"},
]


#: Folders of data, read by name.
DATA = {"cases"}


@cache
def imports():
    """The modules that each module imports, at the top or in a function; not those for type checkers only."""
    modules = {
        ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__"): path
        for path in SOURCE.rglob("*.py")
    }
    found = {}
    for name, path in modules.items():
        if path.name == "__init__.py" and path.parent == SOURCE:
            continue  # the public names, made when they are asked for
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in [n for n in ast.walk(tree) if isinstance(n, ast.If)]:
            if "TYPE_CHECKING" in ast.dump(node.test):
                node.body = []
        names = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        within = {n.removeprefix("myostrain.") for n in names if n.startswith("myostrain.")}
        found[name] = {n for n in within if n in modules and n != name}
    return found


def part(module):
    return module.split(".")[0]


def layer(name):
    return next(level for level, parts in enumerate(LAYERS) if name in parts)


def test_every_part_has_its_layer():
    """A new folder or module at the top has to say where it belongs."""
    parts = {part(name) for name in imports()} - DATA - {"__init__"}
    assert parts == set().union(*LAYERS)


@pytest.mark.parametrize("name", sorted(set().union(*LAYERS)))
def test_nothing_reaches_back(name):
    """What a part imports lies below it, or in its own folder."""
    wrong = {
        (module, other)
        for module, others in imports().items()
        for other in others
        if part(module) == name and part(other) not in DATA | {name} and layer(part(other)) >= layer(name)
    }
    assert not wrong


def test_no_circles():
    """No module imports itself by way of others."""
    graph, done = imports(), set()

    def visit(name, above):
        assert name not in above, " -> ".join([*above[above.index(name) :], name])
        if name in done:
            return
        for other in sorted(graph.get(name, ())):
            # A folder's __init__ only gathers what the folder has.
            if not (
                other in graph and (SOURCE / other.replace(".", "/")).is_dir() and part(other) == part(name)
            ):
                visit(other, [*above, name])
        done.add(name)

    for name in sorted(graph):
        if not (SOURCE / name.replace(".", "/")).is_dir():
            visit(name, [])


def test_few_modules_at_the_top():
    """At most sixteen."""
    assert len(list(SOURCE.glob("*.py"))) <= 16
