"""The version of the package, its one source, without an import."""

__version__ = '1.0.0rc1'
