"""The figures and the claims of the chapter, drawn and measured from runs of this package."""
