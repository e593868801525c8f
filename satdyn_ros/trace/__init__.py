"""
From plain functions of floats to machine code; the room knows nothing of satellites.

A function is called once with symbols in place of floats (graph.py).  What it does to them is
written as LLVM IR, for one motion or for several in the lanes of vectors (emit.py), and becomes
machine code, which is kept for the next start (load.py).  No operation is contracted, reordered or
left out: the source defines the bits, and ieee.py is what they are in Python.
"""
