"""Files of volumes, made by the libraries that define them, with values that differ everywhere."""

import struct
import zlib

import nibabel
import numpy as np
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian, MRImageStorage, generate_uid
from scipy.spatial.transform import Rotation

SHAPE = (10, 12, 14)
VALUES = (np.arange(np.prod(SHAPE)).reshape(SHAPE) * 7 % 2999 - 500).astype(np.int16)
"""Gray levels (plane, row, col)."""

TURN = Rotation.from_euler("xyz", (20.0, -35.0, 110.0), degrees=True).as_matrix()
ACROSS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
OBLIQUE = (tuple(TURN[:, 0]), tuple(TURN[:, 1]))
SERIES = generate_uid(entropy_srcs=["a series"])


def affine(sides=(0.5, 0.75, 2.0), turn=TURN, origin=(-31.5, 17.25, 4.0)):
    """Matrix from (col, row, plane), in single precision as NIfTI holds it."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn * sides, origin
    return matrix.astype(np.float32).astype(np.float64)


def write_nifti(path, values=VALUES, matrix=None, kind=nibabel.Nifti1Image, **header):
    image = kind(values.T, affine() if matrix is None else matrix)
    for name, value in header.items():
        image.header[name] = value
    nibabel.save(image, path)
    return image


def dataset(values, position=(0.0, 0.0, 0.0), along=ACROSS, spacing=(0.75, 0.5), number=1, **changes):
    """A DICOM slice; entries that are None are left out."""
    found = FileDataset(None, {}, file_meta=FileMetaDataset(), preamble=bytes(128))
    found.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    found.file_meta.MediaStorageSOPClassUID = MRImageStorage
    found.file_meta.MediaStorageSOPInstanceUID = generate_uid(entropy_srcs=[str(number), str(position), str(changes)])
    found.SOPClassUID, found.SOPInstanceUID = MRImageStorage, found.file_meta.MediaStorageSOPInstanceUID
    found.Modality, found.SeriesInstanceUID, found.SeriesDescription = "MR", SERIES, "head"
    found.InstanceNumber = number
    found.Rows, found.Columns = values.shape[-2:]
    found.SamplesPerPixel, found.PhotometricInterpretation = 1, "MONOCHROME2"
    found.BitsAllocated = found.BitsStored = 8 * values.itemsize
    found.HighBit = found.BitsStored - 1
    found.PixelRepresentation = int(values.dtype.kind == "i")
    found.PixelSpacing, found.SliceThickness = list(spacing), 9.0
    found.ImagePositionPatient = [float(f"{x:.8g}") for x in position]
    found.ImageOrientationPatient = [float(f"{x:.10f}") for direction in along for x in direction]
    found.PixelData = np.ascontiguousarray(values).tobytes()
    for name, value in changes.items():
        if value is None:
            delattr(found, name)
        else:
            setattr(found, name, value)
    return found


def write_slice(path, *given, **changes):
    dataset(*given, **changes).save_as(path, enforce_file_format=True)


def write_series(folder, heights, along=ACROSS, values=VALUES, origin=(-20.0, 10.0, 5.0), **changes):
    """A file for each slice, in an order of names that is not that of the heights."""
    folder.mkdir(exist_ok=True)
    normal = np.cross(*along)
    for number, height in enumerate(heights, start=1):
        position = np.array(origin) + height * normal
        name = f"{number * 37 % 101:03d}.dcm"
        write_slice(folder / name, values[(number - 1) % len(values)], position, along, number=number, **changes)
    return folder


def write_metaimage(path, values=VALUES, packed=False, matrix=None, beside=None, **entries):
    """A MetaImage as ITK writes it."""
    matrix = affine() if matrix is None else matrix
    sides = np.linalg.norm(matrix[:3, :3], axis=0)
    kinds = {"int16": "MET_SHORT", "uint8": "MET_UCHAR", "float32": "MET_FLOAT"}
    content = np.ascontiguousarray(values).tobytes()
    content = zlib.compress(content) if packed else content
    lines = {
        "ObjectType": "Image",
        "NDims": 3,
        "BinaryData": "True",
        "BinaryDataByteOrderMSB": "False",
        "CompressedData": str(packed),
        **({"CompressedDataSize": len(content)} if packed else {}),
        "TransformMatrix": " ".join(map(repr, (matrix[:3, :3] / sides).T.ravel().tolist())),
        "Offset": " ".join(map(repr, matrix[:3, 3].tolist())),
        "ElementSpacing": " ".join(map(repr, sides.tolist())),
        "DimSize": " ".join(map(str, values.shape[:3][::-1])),
        "ElementType": kinds[values.dtype.name],
        **entries,
        "ElementDataFile": beside or "LOCAL",
    }
    header = "".join(f"{name} = {value}\n" for name, value in lines.items() if value is not None).encode()
    path.write_bytes(header if beside else header + content)
    if beside:
        (path.parent / beside).write_bytes(content)


def jpeg_of_another_size(content, rows, columns):
    """A JPEG whose header names another size."""
    place = content.index(b"\xff\xc0")
    return content[: place + 5] + struct.pack(">2H", rows, columns) + content[place + 9 :]


__all__ = ["pydicom"]
