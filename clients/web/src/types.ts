// The contract's types, from openapi/openapi.json (npm run contract).

import type { components } from "./contract";

type Schemas = components["schemas"];

export type PoseSnapshot = Schemas["PoseSnapshot"];
export type PartPose = Schemas["PartPose"];
export type AssemblySummary = Schemas["AssemblySummary"];
export type MisassemblyInfo = Schemas["MisassemblyInfo"];
export type AssetInfo = Schemas["AssetInfo"];
export type StepInfo = Schemas["StepInfo"];
export type AnnotationInfo = Schemas["AnnotationInfo"];
export type PlacedPose = Schemas["PlacedPose"];
export type StationInfo = Schemas["StationInfo"];
export type StationList = Schemas["StationList"];
export type CameraInfo = Schemas["CameraInfo"];
export type ServerTime = Schemas["ServerTime"];
export type AnchorInfo = Schemas["AnchorInfo"];
export type AnchorRequest = Schemas["AnchorRequest"];
export type Board = NonNullable<AnchorRequest["board"]>;
export type CommandResult = Schemas["CommandResult"];
export type Problem = Schemas["Problem"];
