#include "engine-bridge/scene/drawn/DrawnState.h"

#include <osg/ClipNode>
#include <osg/ClipPlane>
#include <osg/Program>
#include <osg/Shader>

#include <algorithm>
#include <cctype>

namespace midair::bridge
{

namespace
{

/// True for a shader that leaves vertices where the fixed pipeline draws them, by one of the usual
/// lines.
bool leavesVertices(const osg::Shader& shader)
{
    std::string text = shader.getShaderSource();
    text.erase(std::remove_if(
                   text.begin(), text.end(), [](unsigned char c) { return std::isspace(c) != 0; }),
               text.end());
    const auto has = [&text](const char* words) { return text.find(words) != std::string::npos; };
    return has("gl_Position=ftransform();") ||
           has("gl_Position=gl_ModelViewProjectionMatrix*gl_Vertex;") ||
           has("gl_Position=osg_ModelViewProjectionMatrix*osg_Vertex;");
}

bool mayMoveVertices(const osg::Program& program)
{
    for (unsigned int i = 0; i < program.getNumShaders(); ++i)
    {
        const osg::Shader& shader = *program.getShader(i);
        const bool isVertex = shader.getType() == osg::Shader::VERTEX;
        const bool isFragment = shader.getType() == osg::Shader::FRAGMENT;
        if (isVertex ? !leavesVertices(shader) : !isFragment) return true;
    }
    return false;
}

} // namespace

std::string notFeltOf(const osg::Node& node)
{
    const auto* clip = dynamic_cast<const osg::ClipNode*>(&node);
    if (clip && clip->getReferenceFrame() != osg::ClipNode::RELATIVE_RF)
        return "clips in an absolute frame, not in the world; its children are felt whole";
    const osg::StateSet* state = node.getStateSet();
    if (!state) return {};
    const auto* program =
        dynamic_cast<const osg::Program*>(state->getAttribute(osg::StateAttribute::PROGRAM));
    if (program && mayMoveVertices(*program))
        return "has a shader that may move vertices on the graphics card; its children are felt as "
               "they are stored";
    constexpr unsigned int kPlanes = 6;
    for (unsigned int i = 0; i < kPlanes; ++i)
        if (state->getAttribute(osg::StateAttribute::CLIPPLANE, i))
            return "has a clip plane that doesn't clip the haptics; use an osg::ClipNode above the "
                   "haptic object";
    return {};
}

} // namespace midair::bridge
