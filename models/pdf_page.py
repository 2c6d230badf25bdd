"""A PDF of one page: filled rectangles, lines and a little text, in exact millimetres."""

from __future__ import annotations

_POINT_PER_MM = 72 / 25.4


class PdfPage:
    """A page that is drawn on; y goes down from its upper edge.

    Args:
        width_mm, height_mm: of the paper.
    """

    def __init__(self, width_mm: float, height_mm: float) -> None:
        self.width_mm = width_mm
        self.height_mm = height_mm
        # From here on one unit is a millimetre, from the lower left corner.
        self._drawing = [f"{_POINT_PER_MM:.9f} 0 0 {_POINT_PER_MM:.9f} 0 0 cm"]

    def rectangle(self, left_mm: float, top_mm: float, width_mm: float, height_mm: float) -> None:
        """A black one."""
        bottom_mm = self.height_mm - top_mm - height_mm
        self._drawing.append(f"{left_mm:.5f} {bottom_mm:.5f} {width_mm:.5f} {height_mm:.5f} re f")

    def text(self, left_mm: float, baseline_mm: float, height_mm: float, words: str) -> None:
        """A line of Latin text; its letters are about `height_mm` high."""
        escaped = words.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
        y_mm = self.height_mm - baseline_mm
        self._drawing.append(
            f"BT /F1 {height_mm:.3f} Tf {left_mm:.5f} {y_mm:.5f} Td ({escaped}) Tj ET"
        )

    def to_bytes(self) -> bytes:
        """The file (PDF 1.4)."""
        width, height = (each * _POINT_PER_MM for each in (self.width_mm, self.height_mm))
        content = "\n".join(self._drawing).encode("latin-1", "replace")
        objects = [
            b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
            b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
            f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width:.4f} {height:.4f}] "
            "/Contents 4 0 R /Resources << /Font << /F1 5 0 R >> >> >>".encode(),
            b"<< /Length %d >>\nstream\n%b\nendstream" % (len(content), content),
            b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
        ]
        return _file(objects)


def _file(objects: list[bytes]) -> bytes:
    """Objects with their numbers, and the table that tells where each begins."""
    data, places = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n", []
    for number, content in enumerate(objects, start=1):
        places.append(len(data))
        data += b"%d 0 obj\n%b\nendobj\n" % (number, content)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    size = len(objects) + 1
    return data + (
        b"xref\n0 %d\n0000000000 65535 f \n%btrailer\n<< /Size %d /Root 1 0 R >>\n"
        b"startxref\n%d\n%%%%EOF\n" % (size, table, size, len(data))
    )
