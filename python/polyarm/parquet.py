"""Parquet files with numbers, texts, lists of numbers and pictures: a writer, and a reader of what it writes.

It needs only NumPy. It writes what data sets of robots need, so that any library of Parquet reads it: one row group,
one page for each column, plain encoding, gzip. It does not read files of others.
"""
import json
import os
import struct
import zlib

import numpy as np

__all__ = ["Column", "read_table", "write_file", "write_table"]

_MAGIC = b"PAR1"
_LARGEST = 1 << 30  # bytes of one column, and of a file that is read
_MOST_COLUMNS = 10_000
_CREATED_BY = "polyarm"
_BOOLEAN, _INT64, _FLOAT, _DOUBLE, _BYTES = 0, 2, 4, 5, 6
_REQUIRED, _REPEATED = 0, 2
_GZIP, _PLAIN, _RLE = 2, 0, 3
_NUMBERS = {"int64": (_INT64, np.dtype("<i8")), "float32": (_FLOAT, np.dtype("<f4")),
            "float64": (_DOUBLE, np.dtype("<f8"))}


class Column:
    """One column. `kind`: int64, float32, float64, string or image (a PNG in bytes). `lists`: each row has a list."""

    def __init__(self, kind, values, lists=False):
        if kind not in (*_NUMBERS, "string", "image") or (lists and kind == "image"):
            raise ValueError(f"there is no column of {'lists of ' if lists else ''}{kind}")
        self.kind, self.values, self.lists = kind, values, lists

    def __len__(self):
        return len(self.values)


# Thrift's compact protocol, as far as Parquet's footers need it.

def _varint(value):
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _zigzag(value):
    return _varint(value << 1 if value >= 0 else (-value << 1) - 1)


class _Struct:
    """Fields of a Thrift struct, by number: int (i32), _Long, str, bytes, list of one of these, _Struct."""

    def __init__(self, **fields):
        self.fields = sorted((int(name[1:]), value) for name, value in fields.items() if value is not None)

    def encoded(self):
        out, last = bytearray(), 0
        for number, value in self.fields:
            kind, content = _encoded(value)
            step = number - last
            out += bytes([step << 4 | kind]) if 0 < step < 16 else bytes([kind]) + _zigzag(number)
            out += content
            last = number
        return bytes(out) + b"\0"


class _Long(int):
    """An i64."""


def _encoded(value):
    if isinstance(value, _Struct):
        return 12, value.encoded()
    if isinstance(value, _Long):
        return 6, _zigzag(value)
    if isinstance(value, int):
        return 5, _zigzag(value)
    if isinstance(value, str):
        value = value.encode()
    if isinstance(value, bytes):
        return 8, _varint(len(value)) + value
    items = [_encoded(item) for item in value]
    kind = items[0][0] if items else 12
    head = bytes([len(items) << 4 | kind]) if len(items) < 15 else bytes([0xF0 | kind]) + _varint(len(items))
    return 9, head + b"".join(content for _, content in items)


class _Bytes:
    """Reads the same protocol; raises ValueError at what is no such thing."""

    def __init__(self, data, at=0):
        self.data, self.at = data, at

    def take(self, count):
        if count < 0 or self.at + count > len(self.data):
            raise ValueError("the Parquet file ends too early")
        self.at += count
        return self.data[self.at - count:self.at]

    def varint(self):
        out = shift = 0
        while True:
            byte = self.take(1)[0]
            out |= (byte & 0x7F) << shift
            if byte < 0x80:
                return out
            shift += 7
            if shift > 63:
                raise ValueError("a number of the Parquet file is too long")

    def zigzag(self):
        value = self.varint()
        return value >> 1 ^ -(value & 1)

    def value(self, kind, depth=0):
        if depth > 16:
            raise ValueError("the Parquet file is nested too deeply")
        if kind in (1, 2):
            return kind == 1
        if kind in (4, 5, 6):
            return self.zigzag()
        if kind == 8:
            return bytes(self.take(self.varint()))
        if kind == 9:
            head = self.take(1)[0]
            count = head >> 4 if head >> 4 < 15 else self.varint()
            if count > len(self.data):
                raise ValueError("a list of the Parquet file is too long")
            return [self.value(head & 15, depth + 1) for _ in range(count)]
        if kind == 12:
            return self.fields(depth + 1)
        raise ValueError("the Parquet file has a field of an unknown kind")

    def fields(self, depth=0):
        out, last = {}, 0
        while (head := self.take(1)[0]) != 0:
            last = last + (head >> 4) if head >> 4 else self.zigzag()
            out[last] = self.value(head & 15, depth)
        return out


# Columns to pages.

def _plain(kind, values):
    if kind in _NUMBERS:
        return np.ascontiguousarray(values, _NUMBERS[kind][1]).tobytes()
    out = bytearray()
    for value in values:
        content = value.encode() if isinstance(value, str) else bytes(value)
        out += struct.pack("<I", len(content)) + content
    return bytes(out)


def _levels(bits):
    """Levels of 0 and 1 in Parquet's mixture of runs and packed bits."""
    bits = np.asarray(bits, np.uint8)
    groups = -(-len(bits) // 8)
    content = _varint(groups << 1 | 1) + np.packbits(bits, bitorder="little").tobytes()
    return struct.pack("<I", len(content)) + content


def _physical(kind):
    return _NUMBERS[kind][0] if kind in _NUMBERS else _BYTES


def _leaves(name, column):
    """(path, kind, rows' lists or None, values) of each leaf of a column."""
    if column.kind == "image":
        yield [name, "bytes"], "bytes", None, list(column.values)
        yield [name, "path"], "string", None, [""] * len(column)
    elif column.lists:
        rows = [list(row) for row in column.values] if column.kind == "string" else \
            [np.asarray(row).reshape(-1) for row in column.values]
        yield [name, "list", "element"], column.kind, [len(row) for row in rows], \
            [value for row in rows for value in row] if column.kind == "string" else \
            (np.concatenate(rows) if rows else np.empty(0))
    else:
        yield [name], column.kind, None, column.values


def _element(name, **more):
    return _Struct(f4=name, **more)


def _schema(columns):
    text = {"f6": 0, "f10": _Struct(f1=_Struct())}
    yield _element("schema", f5=len(columns))
    for name, column in columns.items():
        if column.kind == "image":
            yield _element(name, f3=_REQUIRED, f5=2)
            yield _element("bytes", f1=_BYTES, f3=_REQUIRED)
            yield _element("path", f1=_BYTES, f3=_REQUIRED, **text)
            continue
        leaf = {"f1": _physical(column.kind), "f3": _REQUIRED, **(text if column.kind == "string" else {})}
        if column.lists:
            yield _element(name, f3=_REQUIRED, f5=1, f6=3, f10=_Struct(f3=_Struct()))
            yield _element("list", f3=_REPEATED, f5=1)
            yield _element("element", **leaf)
        else:
            yield _element(name, **leaf)


def _page(lengths, kind, values):
    """The content of a data page, and the number of its levels."""
    content = _plain(kind, values)
    if lengths is None:
        return content, len(values)
    first, defined = [], []
    for length in lengths:  # an empty list has one level, which says that it is empty
        first += [0] + [1] * (length - 1)
        defined += [1] * length or [0]
    return _levels(first) + _levels(defined) + content, len(first)


def _statistics(lengths, kind, values):
    if lengths is not None or kind not in _NUMBERS or len(values) == 0:
        return None
    array = np.asarray(values, _NUMBERS[kind][1])
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        return None
    return _Struct(f3=_Long(0), f5=array.max().tobytes(), f6=array.min().tobytes())


def encode_table(columns, metadata=None):
    """The bytes of a Parquet file. `columns`: {name: Column}, all of one length. `metadata`: {text: text}."""
    rows = {len(column) for column in columns.values()}
    if len(rows) != 1 or len(columns) > _MOST_COLUMNS:
        raise ValueError("the columns of a table have one length")
    out, chunks = bytearray(_MAGIC), []
    for name, column in columns.items():
        for path, kind, lengths, values in _leaves(name, column):
            page, count = _page(lengths, kind, values)
            if len(page) > _LARGEST:
                raise ValueError(f"the column '{name}' has more than 1 GiB: record shorter episodes")
            packer = zlib.compressobj(6, zlib.DEFLATED, 31)
            packed = packer.compress(page) + packer.flush()
            head = _Struct(f1=0, f2=len(page), f3=len(packed),
                           f5=_Struct(f1=count, f2=_PLAIN, f3=_RLE, f4=_RLE)).encoded()
            start = len(out)
            out += head + packed
            chunks.append(_Struct(f2=_Long(start), f3=_Struct(
                f1=_physical(kind), f2=[_PLAIN, _RLE], f3=path, f4=_GZIP, f5=_Long(count),
                f6=_Long(len(head) + len(page)), f7=_Long(len(head) + len(packed)), f9=_Long(start),
                f12=_statistics(lengths, kind, values))))
    count = rows.pop()
    group = _Struct(f1=chunks, f2=_Long(len(out) - len(_MAGIC)), f3=_Long(count))
    pairs = [_Struct(f1=key, f2=value) for key, value in (metadata or {}).items()]
    footer = _Struct(f1=2, f2=list(_schema(columns)), f3=_Long(count), f4=[group], f5=pairs or None,
                     f6=_CREATED_BY).encoded()
    return bytes(out) + footer + struct.pack("<I", len(footer)) + _MAGIC


def write_file(path, content):
    """Replaces a file at once, so that a power cut leaves the old or the new one."""
    waiting = f"{path}.writing"
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(waiting, "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(waiting, path)
    folder = os.open(os.path.dirname(path) or ".", os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def write_table(path, columns, metadata=None):
    write_file(path, encode_table(columns, metadata))


# The way back.

def _bits(data, count):
    reader = _Bytes(data)
    size = struct.unpack("<I", reader.take(4))[0]
    packed = _Bytes(reader.take(size))
    head = packed.varint()
    if not head & 1:
        raise ValueError("the levels of the Parquet file are not those of this writer")
    bits = np.unpackbits(np.frombuffer(bytes(packed.take(head >> 1)), np.uint8), bitorder="little")
    if len(bits) < count:
        raise ValueError("the Parquet file has too few levels")
    return bits[:count], reader.at


def _unplain(kind, data, count):
    if kind in _NUMBERS:
        dtype = _NUMBERS[kind][1]
        if len(data) != count * dtype.itemsize:
            raise ValueError("a page of the Parquet file has another size than its values")
        return np.frombuffer(data, dtype).copy()
    reader, out = _Bytes(data), []
    for _ in range(count):
        content = bytes(reader.take(struct.unpack("<I", reader.take(4))[0]))
        out.append(content.decode() if kind == "string" else content)
    return out


def _read_page(data, chunk, kind, lists, rows):
    head = _Bytes(data, chunk[9])
    page = head.fields()
    if chunk[4] != _GZIP or page[1] != 0 or page[2] > _LARGEST:
        raise ValueError("the Parquet file is not of this writer")
    unpacker = zlib.decompressobj(31)
    content = unpacker.decompress(bytes(head.take(page[3])), page[2] + 1)
    if len(content) != page[2]:
        raise ValueError("a page of the Parquet file is damaged")
    count = page[5][1]
    if count > _LARGEST:
        raise ValueError("a page of the Parquet file is too long")
    if not lists:
        if count != rows:
            raise ValueError("the columns of the Parquet file have different lengths")
        return _unplain(kind, content, count)
    first, size = _bits(content, count)
    defined, more = _bits(content[size:], count)
    values = _unplain(kind, content[size + more:], int(defined.sum()))
    starts = np.flatnonzero(first == 0)
    if len(starts) != rows:
        raise ValueError("the columns of the Parquet file have different lengths")
    lengths = np.add.reduceat(defined.astype(int), starts) if rows else []
    ends = np.cumsum(lengths)
    return [values[end - length:end] for end, length in zip(ends, lengths)]


def read_table(path):
    """({name: values}, metadata) of a file that write_table has written. Raises ValueError, OSError."""
    with open(path, "rb") as file:
        data = file.read(_LARGEST + 1)
    if len(data) > _LARGEST or len(data) < 12 or data[:4] != _MAGIC or data[-4:] != _MAGIC:
        raise ValueError(f"{path} is no whole Parquet file")
    size = struct.unpack("<I", data[-8:-4])[0]
    if size > len(data) - 12:
        raise ValueError(f"{path} is no whole Parquet file")
    try:
        footer = _Bytes(data[-8 - size:-8]).fields()
        return _columns(data, footer), {pair[1].decode(): pair[2].decode() for pair in footer.get(5, [])}
    except (KeyError, IndexError, TypeError, AttributeError, zlib.error, UnicodeDecodeError, OverflowError,
            struct.error) as error:
        raise ValueError(f"{path} is no Parquet file of this writer: {error}") from None


def _columns(data, footer):
    kinds = {number: kind for kind, (number, _) in _NUMBERS.items()}
    out, texts = {}, {}
    elements = footer[2]
    for element in elements:
        if element.get(6) == 0:
            texts[element[4]] = True
    for entry in footer[4][0][1]:
        chunk = entry[3]
        path = [part.decode() for part in chunk[3]]
        leaf = path[-1].encode()
        is_list = path[1:] == ["list", "element"]
        kind = kinds.get(chunk[1]) or ("string" if is_list or leaf in texts else "bytes")
        values = _read_page(data, chunk, kind, is_list, footer[3])
        if path[1:] != ["path"]:
            out[path[0]] = values
    return out


def pandas_index(index, columns):
    """The metadata that makes pandas take the column `index` as the index. `columns`: {name: pandas' type}."""
    described = [{"name": name, "field_name": name, "pandas_type": kind,
                  "numpy_type": "object" if kind == "unicode" else kind, "metadata": None}
                 for name, kind in columns.items()]
    return {"pandas": json.dumps({"index_columns": [index], "column_indexes": [], "columns": described,
                                  "creator": {"library": _CREATED_BY, "version": "1"}, "pandas_version": "2.0.0"})}
