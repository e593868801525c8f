"""From IR to machine code, and to the addresses of its functions."""

import functools
import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import llvmlite
from llvmlite import binding

# What keeps the bits.  Vectors of scalars that are side by side do not, and take nine tenths of
# the compiler's time.  Only where there are loops does it pay to look for them.
_LEVEL, _LEVEL_OF_LOOPS = 1, 2
# Bytes of the digest before the code in a file.
_DIGEST = 32


class Code:
    """Functions as machine code, which lasts as long as this object."""

    def __init__(
        self,
        text: str | Callable[[], str],
        folder: Path | None = None,
        cpu: str | None = None,
        name: str = '',
    ):
        """
        Take the code of IR from a folder, or compile it and keep it there.

        cpu: as LLVM names it, the processor here unless it is given.  name: of a function with
        loops, whose text follows from the sources that the folder is for: only where there is no
        code yet is it asked for.
        """
        machine, level = _machine(cpu), _LEVEL_OF_LOOPS if name else _LEVEL
        key = f'{llvmlite.__version__} {machine.triple} {_features(cpu)} {level}\n{name or text}'
        # By all that it is made of: what is kept cannot be stale.
        kept = folder and folder / f'{sha256(key.encode()).hexdigest()[:32]}.o'
        content = _read(kept) if kept else b''
        if not content:
            content = _compiled(text() if callable(text) else text, machine, level)
            if kept:
                with suppress(OSError):
                    _write_whole(kept, sha256(content).digest() + content)
        self._engine = binding.create_mcjit_compiler(binding.parse_assembly(''), machine)
        self._engine.add_object_file(binding.ObjectFileRef.from_data(content))
        self._engine.finalize_object()

    def address(self, name: str) -> int:
        """Return where a function is."""
        return self._engine.get_function_address(name)


def _compiled(text, machine, level):
    module = binding.parse_assembly(text)
    module.verify()
    has_loops = level == _LEVEL_OF_LOOPS
    if hasattr(binding, 'create_pass_builder'):
        options = binding.create_pipeline_tuning_options(speed_level=level)
        options.slp_vectorization, options.loop_vectorization = False, has_loops
        builder = binding.create_pass_builder(machine, options)
        builder.getModulePassManager().run(module, builder)
    else:
        # Before LLVM 15.
        builder = binding.create_pass_manager_builder()
        builder.opt_level, builder.slp_vectorize = level, False
        builder.loop_vectorize = has_loops
        manager = binding.create_module_pass_manager()
        builder.populate(manager)
        manager.run(module)
    return machine.emit_object(module)


@functools.cache
def _target():
    if tuple(map(int, llvmlite.__version__.split('.')[:2])) < (0, 45):
        binding.initialize()
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding.Target.from_default_triple()


def _features(cpu):
    return cpu or f'{binding.get_host_cpu_name()} {binding.get_host_cpu_features().flatten()}'


def _machine(cpu):
    return _target().create_target_machine(
        cpu=cpu or binding.get_host_cpu_name(),
        features='' if cpu else binding.get_host_cpu_features().flatten(),
        opt=_LEVEL,
        reloc='pic',
        codemodel='jitdefault',
        jit=True,
    )


def _read(path):
    """Return the machine code in a file; nothing: it is not there, or damaged."""
    try:
        whole = path.read_bytes()
    except OSError:
        return b''
    # Damaged code would end the process.
    digest, content = whole[:_DIGEST], whole[_DIGEST:]
    return content if sha256(content).digest() == digest else b''


def _write_whole(path, content):
    """Write a file that another process sees whole or not at all."""
    handle, name = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, 'wb') as file:
            file.write(content)
        Path(name).replace(path)
    except OSError:
        Path(name).unlink()
        raise
