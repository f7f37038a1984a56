#pragma once

#include "engine-bridge/HapticObject.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/SequenceComposer.h"

#include <vector>

namespace midair::bridge
{

/// How the points of \a objects (points.object indexes them) are modulated. The array plays one
/// field at a time, so that all share one frequency: that of the modulated object of the highest
/// priority, of equal ones the first; each keeps its depth. What is played otherwise than an object
/// asks for is a message.
haptics::ModulationPlan modulationOf(const std::vector<HapticObject>& objects,
                                     const haptics::ControlPoints& points,
                                     const haptics::ModulatorOptions& everything,
                                     base::MessageLog& messages);

} // namespace midair::bridge
