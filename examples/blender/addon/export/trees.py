# SPDX-License-Identifier: GPL-3.0-or-later
"""Trees of shader nodes with the groups in them."""


def nodes_in(tree):
    """All nodes of a bpy.types.NodeTree, or of None, and of the groups in it, whether anything comes of them or not."""
    for node in tree.nodes if tree is not None else ():
        yield node
        if node.type == "GROUP":
            yield from nodes_in(node.node_tree)
