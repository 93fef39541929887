// From a selection to sentences: names, classes, confidence, what was rejected and what is not identifiable.
#pragma once

#include "diagnosis/evidence/challenge.hpp"
#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/validation/gust_parts.hpp"

namespace gustlab::diagnosis {

// Fills effects, calibration, rejected, not_identifiable and torque_told of a diagnosis.
void explain(const Session& session, const Selection& selection, const Challenge& challenge, Diagnosis& out);
// The class of a finding: what fits best first, the others in catalogue order, each name once.
void put_in_order(EffectFinding& effect);
// Of logs that do not say how commands go on between rows: how strongly a command turns the vehicle is not told by them, so what pushes alike is a
// class. Nothing where both are named or suspected.
void class_what_pushes_alike(Diagnosis& out);
// Says of the channels of time which effects they would show: those that make a command, or a pose, late.
void say_what_channels_show(std::vector<Mismatch>& channels);
// Names `gust` when the flight says so; per axis strength, correlation time and a spectral line.
void explain_gust(const Session& session, const GustParts& parts, Diagnosis& out);
// `[[effect]]` tables of everything found, totals, calibration included.
std::string augmented_toml(const Diagnosis& diagnosis);

}  // namespace gustlab::diagnosis
