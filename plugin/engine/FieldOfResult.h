#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/base/threads/Mutex.h"

#include <osgMidair/HapticField>

#include <memory>

namespace osgMidair
{

/// Makes the public form of a result of which the origins are FeltNodes.
osg::ref_ptr<const HapticField>
fieldOf(std::shared_ptr<const midair::bridge::HologramResult> result);

/// Keeps the public form of the newest result, so that those who ask for the same get the same. All
/// members may be called from any thread.
class NewestField
{
public:
    /// Returns the field of \a result; null if that is null or has no field.
    osg::ref_ptr<const HapticField>
    get(const std::shared_ptr<const midair::bridge::HologramResult>& result) const;

private:
    mutable midair::base::Mutex _mutex;
    mutable std::shared_ptr<const midair::bridge::HologramResult> _result MIDAIR_GUARDED_BY(_mutex);
    mutable osg::ref_ptr<const HapticField> _field MIDAIR_GUARDED_BY(_mutex);
};

} // namespace osgMidair
