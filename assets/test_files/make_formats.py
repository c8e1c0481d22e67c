"""Writes the small files in `formats/` that the tests of `src/recording/formats` read.

    pip install numpy scipy h5py npTDMS pyuff openpyxl
    python make_formats.py

Made with NumPy 2.4.6, SciPy 1.17.1, h5py 3.16.0, npTDMS 1.13.0, pyuff 2.5.8 and openpyxl 3.1.5. All
hold the same recording where the format can: 12 rows, t = 0.00025 i, V = 8 or -8, xp = i - 0.5 i^2.
"""

import gzip
import os
import struct
import sys
import wave
import zipfile

import h5py
import numpy as np
import openpyxl
import pyuff
import scipy.io
import scipy.io.wavfile
import scipy.sparse
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "formats")
N = 12
i = np.arange(N)
t = 0.00025 * i
V = np.where(i % 4 < 2, 8.0, -8.0)
xp = i - 0.5 * i**2
DATE = (2026, 1, 1, 12, 0, 0)


def path(*parts):
    name = os.path.join(OUT, *parts)
    os.makedirs(os.path.dirname(name), exist_ok=True)
    if os.path.exists(name):
        os.remove(name)
    return name


def npy():
    np.save(path("npy", "columns_f8.npy"), np.column_stack([t, V, xp]))
    np.save(path("npy", "fortran_f4.npy"), np.asfortranarray(np.column_stack([V, xp]), dtype="f4"))
    np.save(path("npy", "rows_f8.npy"), np.vstack([t, V, xp]))
    np.save(path("npy", "one_i2.npy"), (xp * 2).astype("i2"))
    np.save(path("npy", "big_endian_i4.npy"), np.column_stack([i, xp * 2]).astype(">i4"))
    np.save(path("npy", "half.npy"), xp.astype("f2"))
    np.save(path("npy", "complex.npy"), (V + 1j * xp).astype("c8"))
    fields = [("when", "M8[ms]"), ("V", "<f4"), ("n", "u1"), ("pos", "<f8", (2,)), ("name", "S3"), ("on", "?")]
    table = np.zeros(N, dtype=np.dtype(fields, align=True))
    table["when"] = np.datetime64("2026-01-01T00:00:00") + i.astype("m8[ms]")
    table["V"], table["n"], table["name"], table["on"] = V, i, b"abc", i % 2
    table["pos"] = np.column_stack([xp, -xp])
    np.save(path("npy", "structured.npy"), table)
    np.save(path("npy", "objects.npy"), np.array([{"a": 1}, "b"], dtype=object))
    np.savez(path("npz", "plain.npz"), t=t, V=V, xp=xp)
    np.savez_compressed(path("npz", "packed.npz"), V=V.astype("f4"), xp=xp, fs=4000.0, slow=np.arange(3),
                        names=np.array(["a", None], dtype=object))


def mat():
    v5 = {"t": t, "V": V, "xp": xp}
    scipy.io.savemat(path("mat5", "rows.mat"), v5)
    scipy.io.savemat(path("mat5", "columns_packed.mat"), v5, do_compression=True, oned_as="column")
    run = {"A": (xp * 2).astype("i2").reshape(-1, 1), "B": V.astype("f4").reshape(-1, 1),
           "Tstart": -0.001, "Tinterval": 0.00025, "name": "run 7"}
    cell = np.empty(2, dtype=object)
    cell[0], cell[1] = xp, "text"
    scipy.io.savemat(path("mat5", "nested.mat"), {
        "run": run, "c": cell, "z": V + 1j * xp, "m": np.column_stack([V, xp]),
        "sp": scipy.sparse.csc_matrix(np.eye(3)), "on": i % 2 == 0}, do_compression=True)
    runs = np.zeros(2, dtype=[("t", object), ("x", object)])
    for k in range(2):
        runs[k] = (t, xp + k)
    scipy.io.savemat(path("mat5", "struct_array.mat"), {"runs": runs}, do_compression=True)
    scipy.io.savemat(path("mat5", "version_4.mat"), v5, format="4")


def matlab_73(name, write):
    """As MATLAB writes: a user block with the header of a MAT file."""
    with h5py.File(name, "w", userblock_size=512) as file:
        write(file)
    with open(name, "r+b") as file:
        text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Thu Jan  1 12:00:00 2026 HDF5 schema 1.00 ."
        file.write(text.ljust(116) + bytes(8) + b"\x00\x02IM")


def variable(file, name, values, kind="double", **options):
    dataset = file.create_dataset(name, data=values, **options)
    dataset.attrs["MATLAB_class"] = np.bytes_(kind)


def hdf5():
    with h5py.File(path("hdf5", "plain.h5"), "w") as file:
        for name, values in [("t", t), ("V", V), ("xp", xp)]:
            file[name] = values
    with h5py.File(path("hdf5", "attributes.h5"), "w") as file:
        # The index of chunks takes 4 kB: one dataset has it.
        packed = {"chunks": (5,), "compression": "gzip", "shuffle": True}
        raw = (xp * 2).astype("i2")
        for name, values, unit, options in [("V", V, "V", {}), ("xp", raw, np.bytes_("um"), packed)]:
            dataset = file.create_dataset("run/" + name, data=values, **options)
            dataset.attrs["units"] = unit
            dataset.attrs["dt"] = 0.00025
            dataset.attrs["t0"] = 0.1
    with h5py.File(path("hdf5", "latest.h5"), "w", libver="latest") as file:
        file.attrs["sample_rate"] = 4000
        both = file.create_dataset("data", data=np.column_stack([V, xp]).astype(">f4"), chunks=(4, 2),
                                   maxshape=(None, 2), compression="gzip", fletcher32=True)
        both.attrs["columns"] = ["V", "xp"]
        file["image"] = np.zeros((2, 2, 2))
    with h5py.File(path("hdf5", "compound.h5"), "w") as file:
        table = np.zeros(N, dtype=[("t", "f8"), ("V", "f4"), ("xp", "i2"), ("on", "?")])
        table["t"], table["V"], table["xp"], table["on"] = t, V, xp * 2, i % 2
        file["table"] = table

    with h5py.File(path("hdf5", "lzf.h5"), "w", libver="latest") as file:
        file.create_dataset("xp", data=xp, chunks=(N,), compression="lzf", shuffle=True)

    def write(file):
        variable(file, "t", t.reshape(1, -1), chunks=(1, N), compression="gzip")
        variable(file, "m", np.vstack([V, xp]))
        variable(file, "Fs", [[4000.0]])
        variable(file, "name", np.array([[97], [98]], dtype="u2"), "char")
        empty = file.create_dataset("none", data=np.array([0, 0], dtype="u8"))
        empty.attrs["MATLAB_class"], empty.attrs["MATLAB_empty"] = np.bytes_("double"), np.uint8(1)
        variable(file, "run/V", V.reshape(1, -1))
        variable(file, "run/xp", xp.reshape(1, -1).astype("f4"), "single")
    matlab_73(path("hdf5", "matlab_73.mat"), write)


def tdms():
    wave_of = {"wf_increment": 0.00025, "wf_start_offset": 0.1, "wf_samples": N}

    def channel(name, data, **properties):
        return ChannelObject("run 'a'", name, data, properties={**wave_of, **properties})

    with TdmsWriter(path("tdms", "segments.tdms")) as writer:
        root = RootObject(properties={"name": "made up", "wf_start_time": np.datetime64("2026-01-01")})
        for part in (slice(0, 5), slice(5, 10), slice(10, N)):
            writer.write_segment([root, GroupObject("run 'a'"),
                                  channel("V", V[part], unit_string="V"),
                                  channel("xp", xp[part].astype("f4"), unit_string="um")])
        slow = ChannelObject("slow", "T", np.arange(3, dtype="i4"), properties={"wf_increment": 0.001})
        writer.write_segment([slow, ChannelObject("log", "note", ["one", "two"])])
    scale = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 2, "NI_Scale[0]_Scale_Type": "Linear",
             "NI_Scale[0]_Linear_Slope": 0.5, "NI_Scale[0]_Linear_Y_Intercept": 0.25,
             "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF, "NI_Scale[1]_Scale_Type": "Polynomial",
             "NI_Scale[1]_Polynomial_Coefficients_Size": 3, "NI_Scale[1]_Polynomial_Coefficients[0]": 1.0,
             "NI_Scale[1]_Polynomial_Coefficients[1]": 2.0, "NI_Scale[1]_Polynomial_Coefficients[2]": 0.125,
             "NI_Scale[1]_Polynomial_Input_Source": 0}
    with TdmsWriter(path("tdms", "scaled.tdms")) as writer:
        raw = (xp * 2).astype("i2")
        writer.write_segment([channel("xp", raw, unit_string="um", **scale),
                              channel("bridge", raw, unit_string="N",
                                      **{"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Strain"}),
                              ChannelObject("run 'a'", "when", np.datetime64("2026-01-01") + i.astype("m8[ms]"))])


def uff():
    def sets(name, functions, byte_order="little", single=False, first=None):
        file = pyuff.UFF(path("uff", name))
        if first:
            file.write_sets([first], "add")
        sys_of = pyuff.datasets.dataset_58.sys
        pyuff.datasets.dataset_58.sys = type("sys", (), {"byteorder": byte_order})
        try:
            file.write_sets(functions, "add", force_double=not single)
        finally:
            pyuff.datasets.dataset_58.sys = sys_of

    def function(data, unit, kind, node, binary=0, even=1, single=False, **more):
        return {"type": 58, "binary": binary, "func_type": 1, "rsp_node": node, "rsp_dir": 3, "ref_node": 1,
                "ref_dir": 3, "data": data, "x": t if even else t**1.5, "abscissa_spacing": even, "id1": kind,
                "rsp_ent_name": "Beam", "abscissa_spec_data_type": 17, "ordinate_spec_data_type": 8,
                "abscissa_axis_units_lab": "s", "ordinate_axis_units_lab": unit, "orddenom_spec_data_type": 0,
                "z_axis_spec_data_type": 0, "ord_data_type": 2 if single else 4, **more}

    two = lambda **o: [function(V, "V", "Drive", 0, **o), function(xp, "um", "Displacement", 7, **o)]
    sets("ascii_even.uff", two())
    sets("ascii_even_single.uff", two(single=True), single=True)
    sets("ascii_uneven.uff", two(even=0))
    sets("binary_little.uff", two(binary=1))
    sets("binary_big.uff", two(binary=1), byte_order="big")
    sets("binary_uneven.uff", two(binary=1, even=0))
    frf = function(V + 1j * xp, "m/N", "FRF", 3, binary=1, abscissa_spec_data_type=18)
    frf["func_type"] = 4
    sets("with_spectrum.uff", [*two(binary=1), frf])
    sets("only_spectrum.uff", [frf])
    mm = {"type": 164, "units_code": 5, "units_description": "MM: mm (newton)", "temp_mode": 1, "length": 1000.0,
          "force": 1.0, "temp": 1.0, "temp_offset": 0.0}
    sets("units_164.uff", [function(xp, "NONE", "Displacement", 7)], first=mm)


def sheets():
    book = openpyxl.Workbook()
    book.loaded_theme = b"<a:theme xmlns:a='http://schemas.openxmlformats.org/drawingml/2006/main' name='x'/>"
    sheet = book.active
    sheet.title = "run"
    sheet.append(["Made up", None, "2026"])
    sheet.append(["t", "V", "xp", "when", "german"])
    sheet.append(["[s]", "V", "um", None, None])
    import datetime
    for k in range(N):
        when = datetime.datetime(2026, 1, 1, 12, 0, 0) + datetime.timedelta(seconds=k)
        german = f"{xp[k]:.2f}".replace(".", ",")
        sheet.append([t[k], V[k], "OL" if k == 3 else xp[k], when, german])
    other = book.create_sheet("empty")
    other["A1"] = "only text"
    third = book.create_sheet("second")
    for k in range(3):
        third.append([k, k * k])
    settings = book.create_sheet("settings")
    for row in (["Rate", 4000], ["Points", 3], ["t [s]", "x"], [0, 0.5], [1, 1.5], [2, 2.5]):
        settings.append(row)
    name = path("xlsx", "sheets.xlsx")
    book.save(name)


def sounds():
    def write(name, width, frames, channels=2):
        with wave.open(path("wav", name), "wb") as file:
            file.setnchannels(channels)
            file.setsampwidth(width)
            file.setframerate(4000)
            file.writeframes(frames)

    both = np.column_stack([V * 1000, xp * 100]).astype("<i2")
    write("pcm16.wav", 2, both.tobytes())
    write("pcm24.wav", 3, b"".join(struct.pack("<i", int(v) * 256)[:3] for v in both.ravel()))
    write("pcm8.wav", 1, (i * 20).astype("u1").tobytes(), 1)
    scipy.io.wavfile.write(path("wav", "float.wav"), 4000, np.column_stack([V, xp]).astype("f4"))
    scipy.io.wavfile.write(path("wav", "pcm32.wav"), 4000, (V * 2**20).astype("i4"))


def wrapped():
    text = "t [s],V [V],xp [um]\n" + "".join(f"{a},{b},{c}\n" for a, b, c in zip(t, V, xp))
    with open(path("wrapped", "run.csv.gz"), "wb") as raw, gzip.GzipFile("run.csv", "wb", fileobj=raw, mtime=0) as file:
        file.write(text.encode())
    def pack(name, entries):
        with zipfile.ZipFile(path("wrapped", name), "w", zipfile.ZIP_DEFLATED) as archive:
            for entry, content in entries:
                archive.writestr(zipfile.ZipInfo(entry, DATE), content, zipfile.ZIP_DEFLATED)
    pack("phyphox.zip", [("Raw Data.csv", text), ("meta/device.csv", "a,b\n"), ("meta/time.csv", "a,b\n")])
    pack("two.zip", [("b/run 1.csv", text), ("__MACOSX/._run 1.csv", "x"), ("run 2.csv", text)])


for make in (npy, mat, hdf5, tdms, uff, sheets, sounds, wrapped):
    make()
