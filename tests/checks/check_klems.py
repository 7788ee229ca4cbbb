#!/usr/bin/env python3
"""Writes Klems matrices of closed forms, of each basis that is known, and compares what the program says of them.

usage: check_klems.py PROGRAM
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

BASES = {
    "LBNL/Klems Full": ([0, 5, 15, 25, 35, 45, 55, 65, 75, 90], [1, 8, 16, 20, 24, 24, 24, 16, 12]),
    "LBNL/Klems Half": ([0, 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90], [1, 8, 12, 16, 20, 12, 8]),
    "LBNL/Klems Quarter": ([0, 9, 27, 45, 63, 90], [1, 8, 12, 12, 8]),
    "own rings": ([0, 20, 50, 90], [1, 3, 6]),
}


def patches(basis):
    """Bounds of theta, centres of phi, widths of phi [degrees] and projected solid angles."""
    bounds, counts = BASES[basis]
    rows = []
    for low, high, count in zip(bounds, bounds[1:], counts):
        solid = np.pi * (np.sin(np.radians(high)) ** 2 - np.sin(np.radians(low)) ** 2) / count
        rows += [(low, high, k * 360 / count, 360 / count, solid) for k in range(count)]
    return np.array(rows).T


def xml(basis, matrix, order, define, commas):
    """`matrix` is [outgoing, incident]."""
    rings = ""
    for low, high, count in zip(*(BASES[basis][0][:-1], BASES[basis][0][1:], BASES[basis][1])) if define else ():
        rings += (f"<AngleBasisBlock><Theta>{(low + high) / 2}</Theta><nPhis>{count}</nPhis><ThetaBounds><LowerTheta>{low}"
                  f"</LowerTheta><UpperTheta>{high}</UpperTheta></ThetaBounds></AngleBasisBlock>\n")
    listed = matrix if order == "Columns" else matrix.T
    numbers = "\n".join(("," if commas else "\t").join(f"{v:.7e}" for v in row) + ("," if commas else "") for row in listed)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov"><WindowElementType>System</WindowElementType><Optical><Layer>
<Material><Name>closed form</Name></Material>
<DataDefinition><IncidentDataStructure>{order}</IncidentDataStructure>
<AngleBasis><AngleBasisName>{basis}</AngleBasisName>{rings}</AngleBasis></DataDefinition>
<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">Visible</Wavelength>
<WavelengthDataBlock><WavelengthDataDirection>Reflection Front</WavelengthDataDirection>
<ColumnAngleBasis>{basis}</ColumnAngleBasis><RowAngleBasis>{basis}</RowAngleBasis>
<ScatteringDataType>BTDF</ScatteringDataType>
<ScatteringData>
{numbers}
</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>
"""


def closed_form(theta_in, phi_in, theta_out, phi_out):
    """A lobe around the mirror direction, which is the same azimuth in and out, and a grain."""
    i, o = np.radians(theta_in), np.radians(theta_out)
    cosine = np.cos(i) * np.cos(o) + np.sin(i) * np.sin(o) * np.cos(np.radians(phi_in - phi_out))
    return 0.02 + 0.3 * np.exp((cosine - 1) * 8) * (1 + 0.2 * np.sin(np.radians(phi_out)))


def evaluate(program, path, angles):
    rows = "".join(",".join(map(repr, row)) + "\n" for row in angles.tolist())
    done = subprocess.run([program, "eval", path], input="theta_i,phi_i,theta_v,phi_v\n" + rows, capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].split(",")[4:] == ["Y"]
    return np.array([line.split(",")[4] for line in lines[1:]], float)


def check(program, path, basis, order, define, commas):
    low, high, phi, width, solid = patches(basis)
    count = len(low)
    middle = (low + high) / 2
    out, incident = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    matrix = closed_form(middle[incident], phi[incident], middle[out], phi[out])
    path.write_text(xml(basis, matrix, order, define, commas))
    random = np.random.default_rng(2)
    i, o = random.integers(count, size=(2, 20000))

    def within(k):
        """A direction inside of patch k, clear of its bounds."""
        u, v = random.uniform(0.01, 0.99, (2, len(k)))
        return low[k] + u * (high[k] - low[k]), phi[k] + (v - 0.5) * width[k]

    theta_i, phi_i = within(i)
    theta_v, phi_v = within(o)
    angles = np.stack([theta_i, phi_i + 180, theta_v, phi_v], axis=-1)  # the light comes from where it does not go
    found = evaluate(program, path, angles)
    assert np.abs(found / matrix[o, i] - 1).max() < 1e-5, (basis, np.abs(found / matrix[o, i] - 1).max())
    told = json.loads(subprocess.run([program, "info", path, "--json"], capture_output=True, text=True, check=True).stdout)
    largest = float(told["findings"][0]["what"].split("the largest is ")[1].split(",")[0])
    expected = (matrix * solid[:, None]).sum(axis=0).max()
    assert abs(largest / expected - 1) < 1e-3, (largest, expected)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        path = pathlib.Path(name) / "closed.xml"
        check(program, path, "LBNL/Klems Full", "Columns", define=False, commas=True)
        check(program, path, "LBNL/Klems Full", "Rows", define=True, commas=False)
        check(program, path, "LBNL/Klems Half", "Columns", define=False, commas=False)
        check(program, path, "LBNL/Klems Quarter", "Columns", define=False, commas=False)
        check(program, path, "own rings", "Rows", define=True, commas=True)
    print("matrices over Klems patches agree")
    return 0


if __name__ == "__main__":
    sys.exit(main())
