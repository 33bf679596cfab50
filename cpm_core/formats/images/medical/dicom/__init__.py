"""DICOM: single images, films and volumes in one file, and series of slices in a folder, read by pydicom."""
