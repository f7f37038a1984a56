#pragma once

#include "engine-bridge/HapticObject.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/SequenceComposer.h"

#include <vector>

namespace midair::bridge
{

/// The modulation of \a points, whose points.object indexes \a objects. The array plays one field
/// at a time, so all points share one frequency: that of the modulated object of the highest
/// priority, the first one among equals; each keeps its own depth. An object that is played at
/// another frequency than it asks for is a message. If \a everything modulates, no object does.
haptics::ModulationPlan modulationOf(const std::vector<HapticObject>& objects,
                                     const haptics::ControlPoints& points,
                                     const haptics::ModulatorOptions& everything,
                                     base::MessageLog& messages);

} // namespace midair::bridge
