"""Small gmsh files, by gmsh and by hand."""


def write_mesh(path, *, regions=True, outer=False, body=False, step=2.0, version=4.1):
    """Write the rectangle [0, 20] × [0, 6], left half "first", right half "second", ends "left" and "right".

    Args:
        path: The file.
        regions: Whether the halves are named.
        outer: Whether the whole boundary is named too.
        body: Whether both halves together are named too.
        step: Size of the triangles.
        version: Of the format.
    """
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.MeshSizeMin", step)
        gmsh.option.setNumber("Mesh.MeshSizeMax", step)
        model, shapes = gmsh.model, gmsh.model.occ
        halves = [(2, shapes.addRectangle(x, 0, 0, 10, 6)) for x in (0, 10)]
        shapes.fragment(halves[:1], halves[1:])
        shapes.synchronize()
        sides = {}
        for _, line in model.getEntities(1):
            x, _, _ = shapes.getCenterOfMass(1, line)
            sides.setdefault({0.0: "left", 20.0: "right"}.get(round(x, 9), "rest"), []).append(line)
        sides["rest"] = [t for t in sides["rest"] if shapes.getCenterOfMass(1, t)[1] in (0.0, 6.0)]
        model.addPhysicalGroup(1, sides["left"], 31, "left")
        model.addPhysicalGroup(1, sides["right"], 32, "right")
        if outer:
            model.addPhysicalGroup(1, [*sides["left"], *sides["right"], *sides["rest"]], 33, "outer")
        if regions:
            model.addPhysicalGroup(2, [1], 11, "first")
            model.addPhysicalGroup(2, [2], 12, "second")
        if body:
            model.addPhysicalGroup(2, [1, 2], 13, "body")
        model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


MSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
{count}
{nodes}
$EndNodes
$Elements
{number}
{elements}
$EndElements
"""

SQUARE = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
TRIANGLES = ["2 2 7 1 1 2 3", "2 2 7 1 1 3 4"]


def msh(nodes=SQUARE, elements=TRIANGLES):
    """The text of a file: nodes, and elements as kind, number of tags, group, entity, nodes."""
    return MSH.format(
        count=len(nodes),
        nodes="\n".join(f"{i} {node}" for i, node in enumerate(nodes, 1)),
        number=len(elements),
        elements="\n".join(f"{i} {element}" for i, element in enumerate(elements, 1)),
    ).encode()
