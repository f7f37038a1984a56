#pragma once

#include "engine-bridge/hands/osc/OscHands.h"

#include <string>
#include <vector>

#include <oscpack/osc/OscOutboundPacketStream.h>

namespace midair::bridge
{

/// A datagram that OscWriter writes.
inline std::string datagramOf(const std::vector<Hand>& hands, double time_s)
{
    OscWriter writer;
    const std::size_t size = writer.hands(hands, time_s);
    return std::string(writer.data(), size);
}

/// An adult's hand with the index finger's tip at \a x (m).
inline Hand handAt(int id, double x)
{
    return openHandWithIndexTipAt(id, {x, 0.02, 0.15}, Eigen::Quaterniond::Identity());
}

/// A message to /midair/hand, apart from OscWriter, with what may be changed in it.
struct HandMessage
{
    std::string side = "right";
    double time_s = 1.0;
    float age_s = 0.0F;
    int joints = HAND_JOINTS;
    float x = 0.1F;
    float w = 1.0F;
    float radius = 0.007F;
    int valid = 3;
    bool isText = false; ///< the age is a text

    std::string bytes() const
    {
        std::vector<char> room(kMostOscBytes);
        osc::OutboundPacketStream out(room.data(), room.size());
        out << osc::BeginMessage(kOscHand) << side.c_str() << time_s;
        if (isText)
            out << "soon";
        else
            out << age_s;
        for (int i = 0; i < joints; ++i)
            out << x << 0.0F << 0.2F << 0.0F << 0.0F << 0.0F << w << radius
                << static_cast<osc::int32>(valid);
        out << osc::EndMessage;
        return std::string(out.Data(), out.Size());
    }
};

} // namespace midair::bridge
