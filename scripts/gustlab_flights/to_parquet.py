"""A flight log as one Parquet table; a cell without a sample is null, units stand with the columns, the sidecar with the table."""

import io

import pyarrow
import pyarrow.parquet

from .flight_file import FlightFile


def parquet_bytes(flight: FlightFile) -> bytes:
    said = {column: (unit, meaning) for _, columns, unit, meaning in flight.layout() for column in columns}
    said["time_s"] = ("s", "time")
    fields = [pyarrow.field(name, pyarrow.float64(), metadata={"unit": said[name][0], "meaning": said[name][1]})
              for name in flight.columns]
    table = pyarrow.Table.from_arrays([pyarrow.array(values, from_pandas=True) for values in flight.columns.values()],
                                      schema=pyarrow.schema(fields, metadata={"sidecar": flight.sidecar_text}))
    file = io.BytesIO()
    pyarrow.parquet.write_table(table, file, compression="zstd")
    return file.getvalue()
