"""Base of the records in eval.json, and types of their numbers. docs/formats/evaluation-folder.md has them."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from pipenav.evaluation.earlier_schema import todays_keys

Typed = Annotated[float, AfterValidator(lambda value: round(value, 6))]
"""A number that people type, without the last digits that a conversion to radians and back leaves."""

Share = Annotated[float, Field(ge=0, le=1)]
Amount = Annotated[float, Field(ge=0)]
Count = Annotated[int, Field(ge=0)]
Positive = Annotated[int, Field(ge=1)]


class Record(BaseModel):
    """A part of eval.json.

    Unknown keys are skipped, so that a file of a later version that only adds keys can still be read.
    """

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False, populate_by_name=True)

    @model_validator(mode="before")
    @classmethod
    def _todays_keys(cls, given: Any) -> Any:
        return todays_keys(given)
