#include "engine-bridge/HologramResult.h"
#include "engine-bridge/SceneSnapshot.h"
