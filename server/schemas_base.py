"""What all answers are made of, and the one error body."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Confidence = Annotated[float, Field(ge=0, le=1)]
TimestampUs = Annotated[int, Field(ge=0, description="Unix time, microseconds.")]
Vector3 = Annotated[list[float], Field(min_length=3, max_length=3)]
Quaternion = Annotated[list[float], Field(min_length=4, max_length=4)]
Covariance = Annotated[list[float], Field(min_length=36, max_length=36)]


class Schema(BaseModel):
    """Base of all answers: what is not written here is not said."""

    model_config = ConfigDict(extra="forbid")


class Problem(BaseModel):
    """An error, as in RFC 9457 (application/problem+json). It may carry further members."""

    type: str = Field(default="about:blank", description="What kind of problem.")
    title: str
    status: int = Field(description="The HTTP status.")
    detail: str = Field(description="What is wrong here, and what to do.")
    instance: str = Field(description="The path that was asked for.")
