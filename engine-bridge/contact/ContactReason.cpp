#include "engine-bridge/contact/ContactReason.h"

namespace midair::bridge
{

const char* contactReasonText(ContactReason reason)
{
    switch (reason)
    {
    case ContactReason::NONE:
        return "";
    case ContactReason::TIME_NOT_FINITE:
        return "the time isn't a finite number, or it runs backwards";
    case ContactReason::JOINT_NOT_FINITE:
        return "a joint that counts as tracked has a place that isn't a finite number";
    case ContactReason::RADIUS_OUT_OF_RANGE:
        return "a joint's radius isn't above 0 and at most 100 mm";
    case ContactReason::POSE_NOT_FINITE:
        return "the pose of the object isn't made of finite numbers";
    case ContactReason::MESH_NOT_READY:
        return "the object's mesh is still being prepared";
    case ContactReason::NO_AREA:
        return "what is touched has no area";
    case ContactReason::MATERIAL_INVALID:
        return "a number of the object's material is out of range; it is silent where it is "
               "touched";
    case ContactReason::HAND_JUMPED:
        return "the hand jumped; its contact begins anew";
    }
    return "";
}

} // namespace midair::bridge
