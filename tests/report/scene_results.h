// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "record/temporary_folder.h"

namespace dttmm::host {

/// A body "b" at (1, 2, 3), a quarter turn about z, with a marker "m" at its x = 0.5: in the world at (1, 2.5, 3); its box
/// has the edges 1, 2, 4. A node "n" at (4, 2, 3), a fixed node "Fuß" at (4, 2, 0). A spring from b.m to n, a beam from the
/// foot to n, a spring from the ground to b.
inline constexpr const char* kSceneModel = R"({"bodies": {"b": {"mass": 12, "center_of_mass": [0, 0, 0.25],
    "inertia": [[20, 0, 0], [0, 17, 0], [0, 0, 5]], "position": [1, 2, 3], "rotation": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
    "markers": {"m": [0.5, 0, 0]}}},
    "nodes": {"n": {"position": [4, 2, 3], "rotation": [[1,0,0],[0,1,0],[0,0,1]], "fixed": []},
              "Fuß": {"position": [4, 2, 0], "rotation": [[1,0,0],[0,1,0],[0,0,1]], "fixed": ["x","y","z","rx","ry","rz"]}},
    "elements": {"spring": {"type": "spring_damper", "from": "b.m", "to": "n"},
                 "leg": {"type": "beam", "from": "Fuß", "to": "n", "section": {"tube": [0.2, 0.01], "circle": [null]}},
                 "ground spring": {"type": "spring_damper", "from": "ground", "to": "b"}}})";

inline void write_scene_summary(const TemporaryFolder& folder, const std::string& kind, const std::string& members = "") {
    write_text(folder / "summary.json", "{\"format\": \"dttmm-" + kind + "/1\", \"title\": \"a \\\"ü\\\" & <b>\"" + members +
                                            ", \"model\": " + kSceneModel + "}");
}

/// Three rows at uneven times: b moves, and turns about z by another quarter and by nearly half a turn; n moves along z
/// and turns about y. The force of the spring is 5 N, 13 N, 0.
inline void write_scene_run(const TemporaryFolder& folder) {
    write_scene_summary(folder, "summary");
    write_text(folder / "history.csv",
               "time,b.position.x,b.position.y,b.position.z,b.quaternion.w,b.quaternion.x,b.quaternion.y,b.quaternion.z,"
               "n.position.x,n.position.y,n.position.z,n.rotation.x,n.rotation.y,n.rotation.z,spring.force.x,spring.force.y,"
               "spring.force.z\ns,m,m,m,1,1,1,1,m,m,m,rad,rad,rad,N,N,N\n"
               "0.5,1,2,3,0.7071067811865476,0,0,0.7071067811865476,4,2,3,0,0,0,3,4,0\n"
               "0.75,1.5,2,3,0,0,0,1,4,2,3.5,0,0.2,0,5,0,12\n"
               "1.5,2,3,5,0.9,0,0,-0.4358898943540674,4,2,4,0,0.4,0,0,0,0\n");
}

inline constexpr const char* kSceneModes = R"(, "modes": [
    {"frequency_hz": 0, "modal_mass": 3, "shape": {"b": [1, 0, 0, 0, 0, 0], "b.m": [1, 0, 0, 0, 0, 0], "n": [1, 0, 0, 0, 0, 0],
     "Fuß": [0, 0, 0, 0, 0, 0]}},
    {"frequency_hz": 12.5, "modal_mass": 0.5, "shape": {"b": [0, 0, 0.5, 0, 0, 2], "b.m": [-1, 0, 0.5, 0, 0, 2],
     "n": [0, 0.25, 0, 0.1, 0, 0], "Fuß": [0, 0, 0, 0, 0, 0]}}])";

inline void write_scene_modes(const TemporaryFolder& folder) {
    write_scene_summary(folder, "modes", kSceneModes);
    write_text(folder / "shapes.csv",
               "mode,frequency,element,s,x,y,z,ux,uy,uz,urx,ury,urz\n1,Hz,,m,m,m,m,1,1,1,1/m,1/m,1/m\n"
               "1,0,leg,0,4,2,0,0,0,0,0,0,0\n1,0,leg,1.5,4,2,1.5,0.4,0,0,1,2,3\n1,0,leg,3,4,2,3,1,0,0,0,0,0\n"
               "2,12.5,leg,0,4,2,0,0,0,0,0,0,0\n2,12.5,leg,1.5,4,2,1.5,0,0.75,0,4,5,6\n2,12.5,leg,3,4,2,3,0,0.25,0,0,0,0\n");
}

inline void write_scene_equilibria(const TemporaryFolder& folder) {
    write_scene_summary(folder, "static");
    write_text(
        folder / "static.csv",
        "case,b.position.x,b.position.y,b.position.z,n.position.x,n.position.y,n.position.z,spring.force.x,spring.force.y,"
        "spring.force.z\n,m,m,m,m,m,m,N,N,N\nsnow,1,2,2.999,4,2,2.998,0,0,7\nwind,,,,,,,,,\nboth,3,2,3,4,2,3,1,0,0\n");
}

}  // namespace dttmm::host
