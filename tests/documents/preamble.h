// What fragments of C++ in the documents stand among: each is compiled as the body of a function
// with these arguments.
#include <osgMidair/Calibration>
#include <osgMidair/FieldBaker>
#include <osgMidair/FieldPicture>
#include <osgMidair/HandBodies>
#include <osgMidair/HandSender>
#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>
#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticPoints>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>
#include <osgMidair/MouseHand>
#include <osgMidair/Recording>
#include <osgMidair/RigidBodyCallback>

#include <osg/MatrixTransform>
#include <osgDB/ReadFile>
#include <osgViewer/Viewer>

#include <iostream>

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <CLI/CLI.hpp>

#define FRAGMENT_ARGUMENTS                                                                         \
    [[maybe_unused]] osgMidair::HapticScene *scene,                                                \
        [[maybe_unused]] osgMidair::HapticSurface *surface,                                        \
        [[maybe_unused]] osgMidair::InjectedHands *injected,                                       \
        [[maybe_unused]] osgMidair::MouseHand *mouse,                                              \
        [[maybe_unused]] osgMidair::TouchCallback *callback,                                       \
        [[maybe_unused]] btDiscreteDynamicsWorld &bulletWorld, [[maybe_unused]] btRigidBody &body, \
        [[maybe_unused]] osg::ref_ptr<osgMidair::RigidBodyWorld> world,                            \
        [[maybe_unused]] CLI::App &app, [[maybe_unused]] osg::MatrixTransform *transform,          \
        [[maybe_unused]] osgViewer::Viewer &viewer
