# Nothing is needed without a display: the package patchwright_workbench is imported as it is.
