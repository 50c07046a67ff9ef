// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include "model/read_model.h"
#include "step/simulation.h"
using namespace dttmm;
int main(int c, char** v) { try {
  Plugins plugins; ModelOverrides o; if(c>2) o.step=v[2]; if(c>3) o.coupling=v[3]; if(c>4) o.parameters={{"k1",v[4]}};
  Model m = read_model(v[1], plugins.catalogue(), o);
  Simulation s(m, plugins); Recorder r(s.channels()); s.record_to(r);
  for (uint64_t i=0;i<s.step_count();++i) s.step();
  for (size_t i=0;i<s.channels().size();++i) { auto& n=s.channels()[i].name; if(n.find("force.z")!=n.npos||n.find("energy")!=n.npos||n=="plate.position.z"||n.find("acceleration.z")!=n.npos) std::printf("%s peak %.6g final %.9g\n", n.c_str(), r.statistics((int)i).peak, r.statistics((int)i).final);}
  std::printf("omega h %g passes %ld steps %lu fact %ld\n", s.fastest_mode().omega*s.step_size(), s.end_of_step().passes(), s.index(), s.end_of_step().factorisations());
  Simulation b(m, plugins); for(int i=0;i<20000;++i) b.step(); 
  for(int rep=0;rep<5;++rep){auto t0=std::chrono::steady_clock::now(); for(int i=0;i<200000;++i) b.step(); std::printf("%.4g us\n", std::chrono::duration<double>(std::chrono::steady_clock::now()-t0).count()/200000*1e6);} std::printf("passes/step %g\n", double(b.end_of_step().passes())/double(b.index()));
 } catch (const std::exception& e) { std::printf("%s\n", e.what()); return 1; } }
