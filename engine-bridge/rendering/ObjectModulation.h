#pragma once

#include "engine-bridge/HapticObject.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/SequenceComposer.h"

#include <vector>

namespace midair::bridge
{

/// Returns the modulation of \a points, whose points.object indexes \a objects. The array plays one
/// field at a time, so all points share one frequency: that of the modulated object with the
/// highest priority, the first among equals; each keeps its own depth. Reports objects that are
/// played at another frequency than requested. With \a everything, the objects' own modulation is
/// ignored.
haptics::ModulationPlan modulationOf(const std::vector<HapticObject>& objects,
                                     const haptics::ControlPoints& points,
                                     const haptics::ModulatorOptions& everything,
                                     base::MessageLog& messages);

} // namespace midair::bridge
