"""The version of the package, without an import."""




__version__ = '0.1.0'
