#pragma once

#include "engine-bridge/hands/HandSource.h"

#include <algorithm>
#include <locale>
#include <ostream>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Writes frames as RecordedHandSource reads them: one line per joint.
inline void writeHandRecording(std::ostream& out, const std::vector<HandFrame>& frames)
{
    const auto precision = out.precision(10);
    // The reader expects a decimal point.
    const std::locale before = out.imbue(std::locale::classic());
    out << "time_s,hand,joint,x,y,z,qx,qy,qz,qw,radius_m,position_valid,orientation_valid\n";
    for (const HandFrame& frame : frames)
        for (const Hand& hand : frame.hands)
            for (int i = 0; i < HAND_JOINTS; ++i)
            {
                std::string name = jointName(i);
                std::replace(name.begin(), name.end(), ' ', '_');
                const HandJoint& joint = hand.joints[static_cast<std::size_t>(i)];
                const Eigen::Quaterniond& q = joint.orientation;
                out << frame.time_s << "," << hand.id << "," << name << "," << joint.position.x()
                    << "," << joint.position.y() << "," << joint.position.z() << "," << q.x() << ","
                    << q.y() << "," << q.z() << "," << q.w() << "," << joint.radius_m << ","
                    << joint.positionValid << "," << joint.orientationValid << "\n";
            }
    out.imbue(before);
    out.precision(precision);
}

} // namespace midair::bridge
